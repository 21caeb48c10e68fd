//! Links: each leads to a page, an anchor or a file that is there.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};

use super::page::{self, Page};
use crate::{files, workspace};

/// Markdown beside docs/ whose links must hold too.
const OTHER_FILES: [&str; 4] = ["README.md", "ARCHITECTURE.md", "web/README.md", "examples/README.md"];

/// Every link between pages, and every picture.
pub fn check_site(pages: &[Page]) -> Result<()> {
    let folder = workspace::root().join("docs");
    for from in pages {
        for link in &from.links {
            check_link(pages, from, link, &folder).with_context(|| format!("docs/{}.md: link {link}", from.name))?;
        }
    }
    Ok(())
}

fn check_link(pages: &[Page], from: &Page, link: &str, folder: &Path) -> Result<()> {
    match page::target(link)? {
        Some((name, fragment)) => {
            let name = name.unwrap_or(&from.name);
            let page = pages.iter().find(|page| page.name == name).context("expected a page of docs/, found none")?;
            let is_there = fragment.is_none_or(|fragment| page.anchors.iter().any(|anchor| anchor == fragment));
            ensure!(is_there, "expected one of the headings {:?}", page.anchors);
        }
        None if link.contains("://") => ensure!(link.starts_with("https://"), "expected https"),
        None if link.starts_with("..") => bail!("expected a file of docs/: the site has no others"),
        None => ensure!(folder.join(link).is_file(), "there is no such file in docs/"),
    }
    Ok(())
}

/// Every relative link of the Markdown outside docs/ leads to a file.
pub fn check_repository() -> Result<()> {
    for name in OTHER_FILES {
        let file = workspace::root().join(name);
        let page = Page::parse(name, &files::read(&file)?).with_context(|| name.to_owned())?;
        check_files(&file, &page.links).with_context(|| name.to_owned())?;
    }
    Ok(())
}

fn check_files(file: &Path, links: &[String]) -> Result<()> {
    let folder = file.parent().map(PathBuf::from).unwrap_or_default();
    for link in links.iter().filter(|link| !link.contains("://")) {
        let path = link.split('#').next().unwrap_or_default();
        if !path.is_empty() && !folder.join(path).exists() {
            bail!("link {link}: there is no such file");
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page(name: &str, text: &str) -> Page {
        Page::parse(name, text).unwrap()
    }

    #[test]
    fn links_to_pages_and_headings_hold() {
        let pages = [page("a", "# A\n[b](b.md#two) [self](#a) [out](https://example.org)"), page("b", "# B\n## Two\n")];
        check_site(&pages).unwrap();
    }

    #[test]
    fn broken_links_are_named_with_their_page() {
        for link in ["none.md", "b.md#three", "no-such.png", "http://example.org", "../src/lib.rs"] {
            let pages = [page("a", &format!("# A\n[x]({link})")), page("b", "# B\n")];
            let error = format!("{:#}", check_site(&pages).unwrap_err());
            assert!(error.contains("docs/a.md") && error.contains(link), "{error}");
        }
    }

    #[test]
    fn a_link_to_a_missing_file_is_an_error() {
        let here = workspace::root().join("README.md");
        check_files(&here, &["docs/format.md#tables".to_owned(), "https://example.org".to_owned()]).unwrap();
        assert!(check_files(&here, &["docs/none.md".to_owned()]).is_err());
    }
}

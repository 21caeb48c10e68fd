//! `docs`: the site for adopters, from docs/ and the demo page; built into target/site/, served on this machine.

mod coverage;
mod examples;
mod links;
mod page;
mod template;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use clap::Args;

use crate::{files, play, progress, setup, wasm, workspace};
use page::Page;

/// The pages in their order, by the names of their files in docs/, under the headings of the menu.
const MENU: [(&str, &[&str]); 3] = [
    ("Use it", &["index", "element", "self-hosting", "headless", "browsers", "errors"]),
    ("Make avatars", &["training", "registration", "format"]),
    ("Inside", &["model-viewer", "method", "gpu", "performance", "reliability", "release"]),
];

/// Files that every example may name, and what they are on the site.
const MEDIA: [(&str, &str); 2] =
    [("avatar.glb", "web/assets/shirt-dancer.glb"), ("dance.pkl", "web/assets/motions/dance_a.pkl")];

/// The small files that stand in for them in tests.
const SMALL_MEDIA: [(&str, &str); 2] =
    [("avatar.glb", "tests/fixtures/tiny.glb"), ("dance.pkl", "web/assets/motions/dance_a.pkl")];

/// How to show it.
#[derive(Args)]
pub struct Options {
    /// Only build target/site/
    #[arg(long)]
    build: bool,
    /// Run the examples and check the links instead of serving
    #[arg(long)]
    check: bool,
    /// The port to serve on [default: 8080 or the next free one]
    #[arg(long)]
    port: Option<u16>,
    /// Do not open a browser
    #[arg(long)]
    no_open: bool,
}

/// Builds what is out of date and the site, then serves it until Ctrl-C, or checks it.
pub fn run(options: &Options) -> Result<()> {
    let toolchain = if options.check { setup::everything()? } else { setup::for_building()? };
    wasm::build(toolchain)?;
    wasm::build_element()?;
    if options.check {
        return check();
    }
    let folder = build()?;
    if options.build {
        eprintln!("Built {}.", workspace::relative(&folder));
        return Ok(());
    }
    play::serve(crate::site::Site::folder(&folder)?, "/docs/index.html", options.port, !options.no_open)
}

/// Writes the whole site into target/site/: the demo page, what it loads, and the documentation.
pub fn build() -> Result<PathBuf> {
    progress::quietly("Building the site", || {
        let (root, folder) = (workspace::root(), workspace::root().join(crate::site::BUILT_SITE));
        files::empty(&folder)?;
        files::copy(&root.join("index.html"), &folder.join("index.html"))?;
        for name in ["demo", "web/lib", "web/assets"] {
            files::copy_folder(&root.join(name), &folder.join(name), |_| true)?;
        }
        write_pages(&folder.join("docs"), &MEDIA)?;
        Ok(folder)
    })
}

/// Builds the documentation with small media, checks every link and runs every example in headless Chromium.
pub fn check() -> Result<()> {
    let folder = workspace::root().join("target/site-check");
    let pages = progress::quietly("Building the documentation", || write_pages(&folder, &SMALL_MEDIA))?;
    links::check_repository()?;
    links::check_site(&pages)?;
    wasm::describe_element()?;
    coverage::check_element()?;
    coverage::check_errors()?;
    examples::run(&folder, &pages)
}

/// Writes pages, examples, style and media into `folder`: all that the documentation needs.
fn write_pages(folder: &Path, media: &[(&str, &str)]) -> Result<Vec<Page>> {
    let root = workspace::root();
    let pages = read_pages(&root.join("docs"))?;
    files::empty(folder)?;
    for page in &pages {
        files::write(&folder.join(format!("{}.html", page.name)), template::page(page, &pages))?;
        for (index, example) in page.examples.iter().enumerate() {
            let file = folder.join("examples").join(page.example_file(index));
            files::write(&file, template::example(page, index, example))?;
        }
    }
    let is_picture = |path: &Path| path.extension().is_some_and(|ending| ending == "png" || ending == "webp");
    files::copy_folder(&root.join("docs"), folder, is_picture)?;
    files::copy_folder(&root.join("docs/site"), &folder.join("style"), |_| true)?;
    files::copy(&root.join("demo/style/tokens.css"), &folder.join("style/tokens.css"))?;
    files::copy_folder(&root.join("demo/fonts"), &folder.join("fonts"), |_| true)?;
    files::copy_folder(&workspace::web().join("lib"), &folder.join("crease-avatar"), |_| true)?;
    for (name, source) in media {
        files::copy(&root.join(source), &folder.join(name))?;
    }
    Ok(pages)
}

/// Reads every page of the menu; a page in the folder that the menu lacks is an error.
fn read_pages(folder: &Path) -> Result<Vec<Page>> {
    let names: Vec<&str> = MENU.iter().flat_map(|(_, names)| names.iter().copied()).collect();
    for file in files::below(folder)?.iter().filter(|file| file.extension().is_some_and(|ending| ending == "md")) {
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        ensure!(names.contains(&name.as_ref()), "{}: not in the menu of docs.rs", workspace::relative(file));
    }
    names
        .iter()
        .map(|name| {
            let file = folder.join(format!("{name}.md"));
            Page::parse(name, &files::read(&file)?).with_context(|| workspace::relative(&file))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_page_is_read_and_no_link_is_broken() {
        let pages = read_pages(&workspace::root().join("docs")).unwrap();
        links::check_site(&pages).unwrap();
        links::check_repository().unwrap();
        assert!(pages.iter().any(|page| !page.examples.is_empty()));
    }
}

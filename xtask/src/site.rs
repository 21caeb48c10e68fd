//! Which file a URL means: only what the page needs, never the rest of the disk.

use std::path::{Component, Path, PathBuf};

use anyhow::{Context, Result};

use crate::workspace;

/// The files that a page may load.
pub struct Site {
    root: PathBuf,
    /// Files and folders under the root that may be read.
    shared: Vec<PathBuf>,
    page: PathBuf,
    /// Whether docs/ means what was built from it.
    has_built_docs: bool,
}

/// Where `cargo xtask docs` builds the site, relative to the root.
pub const BUILT_SITE: &str = "target/site";

impl Site {
    /// Shows `page` (relative to the root), the top folder that it lies in, web/, demo/, and the built documentation as docs/.
    pub fn new(page: &Path) -> Result<Self> {
        Self::under(workspace::root(), page)
    }

    /// Shows a finished site: the folder, all of it, from its index.html on.
    pub fn folder(root: &Path) -> Result<Self> {
        let root = root.canonicalize().with_context(|| format!("cannot find {}", root.display()))?;
        Ok(Site { shared: vec![root.clone()], root, page: PathBuf::from("index.html"), has_built_docs: false })
    }

    fn under(root: &Path, page: &Path) -> Result<Self> {
        let root = root.canonicalize().with_context(|| format!("cannot find {}", root.display()))?;
        let top = page.components().next().context("the page's path is empty")?;
        let mut shared = vec![root.join(top), root.join("web"), root.join("demo")];
        shared.push(root.join(BUILT_SITE).join("docs"));
        let site = Site { root, shared, page: page.to_owned(), has_built_docs: true };
        site.file(&site.page_url()).with_context(|| format!("there is no page {}", page.display()))?;
        Ok(site)
    }

    /// The page's place on the server, starting with a slash.
    pub fn page_url(&self) -> String {
        let path = self.page.to_string_lossy();
        if path == "index.html" { "/".to_owned() } else { format!("/{path}") }
    }

    /// The file behind the path of a URL; none where there is nothing to show.
    pub fn file(&self, url: &str) -> Option<PathBuf> {
        let path = url.split(['?', '#']).next()?.strip_prefix('/')?;
        let path = PathBuf::from(if path.is_empty() { "index.html".to_owned() } else { decode(path)? });
        let is_plain = path.components().all(|part| match part {
            Component::Normal(name) => !name.to_string_lossy().starts_with('.') && name != "node_modules",
            _ => false,
        });
        let path =
            if self.has_built_docs && path.starts_with("docs") { Path::new(BUILT_SITE).join(path) } else { path };
        // Canonical: a link cannot lead out either.
        let file = self.root.join(path).canonicalize().ok()?;
        let is_shared = self.shared.iter().any(|shared| file.starts_with(shared));
        (is_plain && is_shared && file.is_file()).then_some(file)
    }
}

/// Resolves `%20` and the like; none for broken escapes, NUL and text that is not UTF-8.
fn decode(path: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(path.len());
    let mut rest = path.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        if first != b'%' {
            bytes.push(first);
            rest = tail;
            continue;
        }
        let digits = std::str::from_utf8(tail.get(..2)?).ok()?;
        let value = digits.bytes().all(|digit| digit.is_ascii_hexdigit()).then(|| u8::from_str_radix(digits, 16))?;
        bytes.push(value.ok().filter(|&byte| byte != 0)?);
        rest = &tail[2..];
    }
    String::from_utf8(bytes).ok()
}

/// The media type that browsers expect for a file.
pub fn media_type(file: &Path) -> &'static str {
    match file.extension().and_then(|extension| extension.to_str()).unwrap_or_default() {
        "html" => "text/html; charset=utf-8",
        "js" | "mjs" => "text/javascript; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "json" | "map" => "application/json",
        "md" | "txt" | "ts" => "text/plain; charset=utf-8",
        "wasm" => "application/wasm",
        "glb" => "model/gltf-binary",
        "png" => "image/png",
        "jpg" | "jpeg" => "image/jpeg",
        "svg" => "image/svg+xml",
        "webp" => "image/webp",
        "woff2" => "font/woff2",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn site() -> Site {
        Site::under(workspace::root(), Path::new("tests/pages/tiny.html")).unwrap()
    }

    #[test]
    fn the_page_and_the_package_are_shown() {
        let site = site();
        assert_eq!(site.page_url(), "/tests/pages/tiny.html");
        assert!(site.file("/tests/pages/tiny.html?detail=2#top").is_some());
        assert!(site.file("/web/package.json").is_some());
        assert!(site.file("/web/pack%61ge.json").is_some());
    }

    #[test]
    fn nothing_else_is_shown() {
        for url in [
            "/Cargo.toml",
            "/web",
            "/web/../Cargo.toml",
            "/web/%2e%2e/Cargo.toml",
            "/web/..%2fCargo.toml",
            "//etc/passwd",
            "/%2fetc/passwd",
            "/web/.npmrc",
            "/web/node_modules/typescript/package.json",
            "/web/package.json%00",
            "/web/package%2",
            "/web/package%+5.json",
            "web/package.json",
            "/no-such-file",
        ] {
            assert_eq!(site().file(url), None, "{url}");
        }
    }

    #[test]
    fn a_page_that_does_not_exist_is_an_error() {
        let error = Site::new(Path::new("tests/pages/none.html")).err().unwrap().to_string();
        assert!(error.contains("tests/pages/none.html"), "{error}");
    }

    #[test]
    fn media_types_follow_the_extension() {
        for (file, expected) in [
            ("index.html", "text/html; charset=utf-8"),
            ("a/crease.js", "text/javascript; charset=utf-8"),
            ("a/crease_bg.wasm", "application/wasm"),
            ("sequence.json", "application/json"),
            ("avatar.glb", "model/gltf-binary"),
            ("texture.png", "image/png"),
            ("texture.jpg", "image/jpeg"),
            ("motion.pkl", "application/octet-stream"),
            ("no-ending", "application/octet-stream"),
        ] {
            assert_eq!(media_type(Path::new(file)), expected, "{file}");
        }
    }

    #[test]
    #[cfg(unix)]
    fn a_link_leads_out_no_more_than_a_path_does() {
        let root = std::env::temp_dir().join(format!("crease-site-{}", std::process::id()));
        std::fs::create_dir_all(root.join("page")).unwrap();
        std::fs::create_dir_all(root.join("web")).unwrap();
        std::fs::write(root.join("page/index.html"), "a page").unwrap();
        std::fs::write(root.join("secret"), "a secret").unwrap();
        std::os::unix::fs::symlink(root.join("secret"), root.join("page/link")).unwrap();
        std::os::unix::fs::symlink(root.join("page/index.html"), root.join("page/inside")).unwrap();
        let site = Site::under(&root, Path::new("page/index.html")).unwrap();
        assert_eq!(site.file("/page/link"), None);
        assert!(site.file("/page/inside").is_some());
        std::fs::remove_dir_all(&root).unwrap();
    }
}

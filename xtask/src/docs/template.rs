//! The HTML around a page's text, and around an example.

use std::fmt::Write;

use super::MENU;
use super::page::Page;

/// A whole page, with the menu that leads to the others.
pub fn page(page: &Page, all: &[Page]) -> String {
    let (title, body, menu) = (escape(&page.title), &page.body, menu(page, all));
    format!(
        r##"<!doctype html>
<html lang="en">
  <head>
    <meta charset="utf-8" />
    <meta name="viewport" content="width=device-width, initial-scale=1" />
    <meta name="color-scheme" content="light dark" />
    <title>{title} · crease</title>
    <link rel="icon" href="data:," />
    <link rel="stylesheet" href="style/tokens.css" />
    <link rel="stylesheet" href="style/site.css" />
    <script type="module" src="style/site.js"></script>
  </head>
  <body>
    <a class="skip" href="#text">Skip to the text</a>
    <header><a class="mark" href="../index.html">crease</a></header>
    <nav aria-label="Documentation">
{menu}    </nav>
    <main id="text">
{body}    </main>
  </body>
</html>
"##
    )
}

fn menu(current: &Page, all: &[Page]) -> String {
    let mut html = String::new();
    for (heading, names) in MENU {
        writeln!(html, "      <h2>{heading}</h2>\n      <ul>").expect("a string takes everything");
        for page in names.iter().filter_map(|name| all.iter().find(|page| page.name == **name)) {
            let mark = if page.name == current.name { " aria-current=\"page\"" } else { "" };
            let (name, title) = (&page.name, escape(&page.title));
            writeln!(html, "        <li><a href=\"{name}.html\"{mark}>{title}</a></li>").expect("as above");
        }
        html += "      </ul>\n";
    }
    html
}

/// A page that runs an example as it stands; its paths are those of the documentation's own folder.
pub fn example(page: &Page, index: usize, code: &str) -> String {
    let title = escape(&format!("{}, example {}", page.title, index + 1));
    format!(
        r#"<!doctype html>
<html lang="en">
  <head>
    <meta charset="utf-8" />
    <meta name="viewport" content="width=device-width, initial-scale=1" />
    <meta name="color-scheme" content="light dark" />
    <title>{title}</title>
    <link rel="icon" href="data:," />
    <base href="../" />
    <link rel="stylesheet" href="style/tokens.css" />
    <link rel="stylesheet" href="style/example.css" />
    <script type="module" src="crease-avatar/crease-avatar.js"></script>
  </head>
  <body>
{code}  </body>
</html>
"#
    )
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_menu_marks_the_page_that_is_open() {
        let pages = [Page::parse("index", "# Start\n").unwrap(), Page::parse("errors", "# A < B\n").unwrap()];
        let html = page(&pages[1], &pages);
        assert!(html.contains("<a href=\"errors.html\" aria-current=\"page\">A &lt; B</a>"), "{html}");
        assert!(html.contains("<a href=\"index.html\">Start</a>"));
    }
}

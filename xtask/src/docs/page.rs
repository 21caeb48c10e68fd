//! One page: Markdown in, HTML out, with its anchors, links and examples.

use anyhow::{Context, Result, ensure};
use pulldown_cmark::{CodeBlockKind, CowStr, Event, HeadingLevel, Options, Parser, Tag, TagEnd};

/// The info string of code that is shown, can be run by readers, and is run by tests.
const LIVE: &str = "html live";

/// A page of the documentation.
#[derive(Debug)]
pub struct Page {
    /// Its file's name without ending.
    pub name: String,
    /// Text of the first heading.
    pub title: String,
    /// The HTML of its text.
    pub body: String,
    /// Headings that links can name.
    pub anchors: Vec<String>,
    /// Where its links lead, as written in Markdown.
    pub links: Vec<String>,
    /// HTML that can be run.
    pub examples: Vec<String>,
}

impl Page {
    /// Reads a page.
    pub fn parse(name: &str, text: &str) -> Result<Self> {
        let mut page = Page {
            name: name.to_owned(),
            title: String::new(),
            body: String::new(),
            anchors: Vec::new(),
            links: Vec::new(),
            examples: Vec::new(),
        };
        let parsed: Vec<Event> = Parser::new_ext(text, Options::ENABLE_TABLES).collect();
        let mut events = Vec::with_capacity(parsed.len());
        let mut rest = parsed.iter();
        while let Some(event) = rest.next() {
            match event {
                Event::Start(Tag::Heading { level, .. }) => {
                    let text = text_until(rest.as_slice(), |event| matches!(event, Event::End(TagEnd::Heading(_))));
                    if *level == HeadingLevel::H1 && page.title.is_empty() {
                        page.title = text.clone();
                    }
                    let anchor = page.new_anchor(&text);
                    events.push(html(format!("<{level} id=\"{anchor}\">")));
                }
                Event::End(TagEnd::Heading(level)) => events.push(html(format!("</{level}>\n"))),
                Event::Start(Tag::Link { link_type, dest_url, title, id }) => {
                    page.links.push(dest_url.to_string());
                    let (link_type, title, id) = (*link_type, title.clone(), id.clone());
                    events.push(Event::Start(Tag::Link { link_type, dest_url: on_site(dest_url).into(), title, id }));
                }
                Event::Start(Tag::Image { dest_url, .. }) => {
                    page.links.push(dest_url.to_string());
                    events.push(event.clone());
                }
                Event::Start(Tag::CodeBlock(kind)) => {
                    if matches!(kind, CodeBlockKind::Fenced(info) if info.as_ref() == LIVE) {
                        let code = text_until(rest.as_slice(), |event| matches!(event, Event::End(TagEnd::CodeBlock)));
                        page.examples.push(code);
                    }
                    // Long lines scroll, by keyboard too.
                    events.push(html("<pre tabindex=\"0\"><code>".to_owned()));
                    let is_live = matches!(kind, CodeBlockKind::Fenced(info) if info.as_ref() == LIVE);
                    for event in rest.by_ref() {
                        if matches!(event, Event::End(TagEnd::CodeBlock)) {
                            break;
                        }
                        events.push(event.clone());
                    }
                    events.push(html("</code></pre>\n".to_owned()));
                    if is_live {
                        let file = page.example_file(page.examples.len() - 1);
                        events.push(html(format!("<p class=\"run\"><a href=\"examples/{file}\">Run it</a></p>\n")));
                    }
                }
                Event::Start(Tag::Table(_)) => {
                    events.push(html("<div class=\"table\" tabindex=\"0\">".to_owned()));
                    events.push(event.clone());
                }
                Event::End(TagEnd::Table) => {
                    events.push(event.clone());
                    events.push(html("</div>\n".to_owned()));
                }
                other => events.push(other.clone()),
            }
        }
        ensure!(!page.title.is_empty(), "expected a heading of the first level, found none");
        pulldown_cmark::html::push_html(&mut page.body, events.into_iter());
        Ok(page)
    }

    /// The file of an example, in the folder examples/.
    pub fn example_file(&self, index: usize) -> String {
        format!("{}-{}.html", self.name, index + 1)
    }

    fn new_anchor(&mut self, heading: &str) -> String {
        let plain = anchor(heading);
        let taken = |name: &String| self.anchors.contains(name);
        let numbered = (1..).map(|number| if number == 1 { plain.clone() } else { format!("{plain}-{number}") });
        let free = numbered.into_iter().find(|name| !taken(name)).expect("numbers do not end");
        self.anchors.push(free.clone());
        free
    }
}

fn html(text: String) -> Event<'static> {
    Event::Html(CowStr::from(text))
}

/// The text of the events before the one that ends it.
fn text_until(events: &[Event], is_end: impl Fn(&Event) -> bool) -> String {
    events
        .iter()
        .take_while(|event| !is_end(event))
        .filter_map(|event| match event {
            Event::Text(text) | Event::Code(text) => Some(text.as_ref()),
            _ => None,
        })
        .collect()
}

/// A heading as a name for links, as GitHub makes it: lower case, hyphens for spaces, no other signs.
fn anchor(heading: &str) -> String {
    let heading = heading.to_lowercase();
    let kept = heading.chars().filter_map(|character| match character {
        ' ' => Some('-'),
        '-' | '_' => Some(character),
        other => other.is_alphanumeric().then_some(other),
    });
    kept.collect::<String>().trim_matches('-').to_owned()
}

/// Pages link to each other's Markdown; on the site, to each other's HTML.
fn on_site(link: &str) -> String {
    let (path, fragment) = link.split_once('#').map_or((link, None), |(path, fragment)| (path, Some(fragment)));
    let path = match path.strip_suffix(".md") {
        Some(name) if !path.contains("://") => format!("{name}.html"),
        _ => path.to_owned(),
    };
    path + &fragment.map(|fragment| format!("#{fragment}")).unwrap_or_default()
}

/// Where a link of a page leads: page name (none: itself) and anchor; none for what is not a page.
pub fn target(link: &str) -> Result<Option<(Option<&str>, Option<&str>)>> {
    if link.contains("://") || link.starts_with("mailto:") {
        return Ok(None);
    }
    let (path, fragment) = link.split_once('#').map_or((link, None), |(path, fragment)| (path, Some(fragment)));
    if path.is_empty() {
        return Ok(Some((None, fragment)));
    }
    match path.strip_suffix(".md") {
        Some(name) => Ok(Some((Some(name), fragment))),
        None => path.contains('.').then_some(None).with_context(|| format!("the link {link} names no file")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_get_names_and_the_first_is_the_title() {
        let page = Page::parse("a", "# The `src` of it\n\n## Time\n\n## Time\n").unwrap();
        assert_eq!(page.title, "The src of it");
        assert_eq!(page.anchors, ["the-src-of-it", "time", "time-2"]);
        assert!(page.body.contains("<h2 id=\"time-2\">Time</h2>"), "{}", page.body);
        assert!(Page::parse("a", "no heading").is_err());
    }

    #[test]
    fn links_lead_to_html_and_are_noted_as_written() {
        let page = Page::parse("a", "# A\n[b](format.md#tables) [c](https://example.org/x.md)").unwrap();
        assert_eq!(page.links, ["format.md#tables", "https://example.org/x.md"]);
        assert!(page.body.contains("\"format.html#tables\"") && page.body.contains("example.org/x.md"));
    }

    #[test]
    fn live_code_is_shown_escaped_and_can_be_run() {
        let text = "# A\n```html live\n<p>hi</p>\n```\n```html\n<p>dead</p>\n```\n";
        let page = Page::parse("a", text).unwrap();
        assert_eq!(page.examples, ["<p>hi</p>\n"]);
        assert!(page.body.contains("&lt;p&gt;hi&lt;/p&gt;") && page.body.contains("examples/a-1.html"));
        assert_eq!(page.body.matches("Run it").count(), 1);
    }

    #[test]
    fn links_have_a_page_and_an_anchor() {
        assert_eq!(target("format.md#tables").unwrap(), Some((Some("format"), Some("tables"))));
        assert_eq!(target("#tables").unwrap(), Some((None, Some("tables"))));
        assert_eq!(target("https://example.org/").unwrap(), None);
        assert_eq!(target("dancer.png").unwrap(), None);
        assert!(target("nowhere").is_err());
    }
}

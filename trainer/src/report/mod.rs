//! A page about an avatar: how close it comes, where its error lies, and what it looks like. One file that needs no other.

mod chart;
mod pictures;
mod truth;

pub use pictures::{COLUMNS, Photographer, Row, WHOLE_SCALE_METRES};
pub use truth::Truth;

use crate::evaluate::Measures;
use crate::residue::{FrameResidue, Residue};
use crate::run_log::Line;
use base64::prelude::{BASE64_STANDARD, Engine};
use chart::{Axes, Series, chart};
use crease::avatar::Avatar;
use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = include_str!("report.css");
const STAGE_NAMES: [&str; 3] = ["body", "base", "detailed"];
/// Frames are grouped by their distance from the nearest training pose at these, degrees.
const DISTANCE_EDGES: [f32; 5] = [0.0, 5.0, 10.0, 20.0, f32::INFINITY];

/// What a report is made of.
pub struct Report<'a> {
    /// The avatar.
    pub avatar: &'a Avatar,
    /// Bytes of its file.
    pub bytes: usize,
    /// Name of the sequence that it was measured on.
    pub sequence: &'a str,
    /// What it was measured against, for people: "ground truth", for instance.
    pub against: &'a str,
    /// Its error.
    pub residue: &'a Residue,
    /// How lively it is in figures and pictures ([`crease::animate::Options::liveliness`]).
    pub liveliness: f32,
    /// Pictures, or why there are none.
    pub pictures: Result<&'a [Row], &'a str>,
    /// The graphics adapter that drew them.
    pub adapter: &'a str,
    /// The run that trained it, if its log lies beside it.
    pub log: &'a [Line],
    /// The run's options as text, if they lie beside it.
    pub config: Option<&'a str>,
}

/// The page.
pub fn page(report: &Report) -> String {
    let title = format!("{} on {}", report.avatar.name, report.sequence);
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { (title) }
                p {
                    (format!("{:.2} MB. {} frames, against the {}.", report.bytes as f64 / 1e6, report.residue.frames.len(), report.against))
                }
                p { (liveliness(report.liveliness)) }
                (closeness(report.residue))
                (by_frame(&report.residue.frames))
                (by_distance(&report.residue.frames))
                (by_part(report.residue))
                (pictures(report))
                (run(report))
            }
        }
    };
    page.into_string()
}

/// What figures and pictures show of poses far from training.
fn liveliness(liveliness: f32) -> String {
    let worn = match liveliness {
        0.0 => "what is likeliest, which is smooth",
        1.0 => "the folds of the training poses nearest to them, as a player shows them",
        _ => "something between the likeliest surface and the folds of the training poses nearest to them",
    };
    format!("Figures and pictures are of liveliness {liveliness}: poses far from training wear {worn}.")
}

fn closeness(residue: &Residue) -> Markup {
    let evaluation = &residue.evaluation;
    html! {
        h2 { "How close" }
        table {
            tr { th {} th { "scan → mesh, cm" } th { "mesh → scan, cm" } th { "normal consistency" } }
            @for (name, measures) in STAGE_NAMES.iter().zip([evaluation.body, evaluation.base, evaluation.detailed]) {
                tr {
                    th { (name) }
                    td { (format!("{:.3}", measures.scan_to_mesh_cm)) }
                    td { (format!("{:.3}", measures.mesh_to_scan_cm)) }
                    td { (format!("{:.4}", measures.nc)) }
                }
            }
        }
    }
}

fn by_frame(frames: &[FrameResidue]) -> Markup {
    let series = |stage: usize, of: fn(&Measures) -> f64| Series {
        name: STAGE_NAMES[stage],
        points: frames.iter().map(|frame| (frame.frame as f64, of(&frame.stages[stage]))).collect(),
        is_scatter: false,
    };
    let distance = [1, 2].map(|stage| series(stage, |measures| measures.scan_to_mesh_cm));
    let cosine = [0, 1, 2].map(|stage| series(stage, |measures| measures.nc));
    let hardest = hardest(frames);
    html! {
        h2 { "Frame by frame" }
        (chart(&Axes { x: "frame", y: "scan → mesh, cm", logarithmic: false }, &distance))
        (chart(&Axes { x: "frame", y: "normal consistency", logarithmic: false }, &cosine))
        h3 { "The hardest frames" }
        table {
            tr { th { "frame" } th { "from the nearest training pose" } th { "scan → mesh, cm" } th { "mesh → scan, cm" } th { "normal consistency" } }
            @for frame in hardest.iter().take(5) {
                @let detailed = frame.stages[2];
                tr {
                    th { (frame.frame) }
                    td { (frame.pose_distance_degrees.map_or("unknown".into(), |degrees| format!("{degrees:.1}°"))) }
                    td { (format!("{:.3}", detailed.scan_to_mesh_cm)) }
                    td { (format!("{:.3}", detailed.mesh_to_scan_cm)) }
                    td { (format!("{:.4}", detailed.nc)) }
                }
            }
        }
    }
}

/// Frames by the detailed mesh's distance from the scan, farthest first.
pub fn hardest(frames: &[FrameResidue]) -> Vec<FrameResidue> {
    let mut frames = frames.to_vec();
    frames.sort_by(|a, b| b.stages[2].scan_to_mesh_cm.total_cmp(&a.stages[2].scan_to_mesh_cm));
    frames
}

fn by_distance(frames: &[FrameResidue]) -> Markup {
    let known: Vec<(f32, &FrameResidue)> =
        frames.iter().filter_map(|frame| Some((frame.pose_distance_degrees?, frame))).collect();
    if known.is_empty() {
        return html! {};
    }
    let points = |of: fn(&FrameResidue) -> f64| {
        let mut points: Vec<(f64, f64)> =
            known.iter().map(|(degrees, frame)| (f64::from(*degrees), of(frame))).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    let series = [
        Series { name: "base", points: points(|frame| frame.stages[1].scan_to_mesh_cm), is_scatter: true },
        Series { name: "detailed", points: points(|frame| frame.stages[2].scan_to_mesh_cm), is_scatter: true },
    ];
    html! {
        h2 { "By distance from the training poses" }
        p { "Root mean square over all joints but the root of the angle to the nearest pose that was trained on." }
        (chart(&Axes { x: "degrees", y: "scan → mesh, cm", logarithmic: false }, &series))
        table {
            tr { th { "degrees" } th { "frames" } @for name in STAGE_NAMES { th { (name) ", cm / NC" } } }
            @for edges in DISTANCE_EDGES.windows(2) {
                @let within: Vec<&FrameResidue> = known.iter().filter(|(degrees, _)| (edges[0]..edges[1]).contains(degrees)).map(|(_, frame)| *frame).collect();
                @if !within.is_empty() {
                    tr {
                        th { (if edges[1].is_finite() { format!("{} to {}", edges[0], edges[1]) } else { format!("{} and more", edges[0]) }) }
                        td { (within.len()) }
                        @for stage in 0..3 {
                            @let mean = Measures::mean(&within.iter().map(|frame| frame.stages[stage]).collect::<Vec<_>>());
                            td { (format!("{:.3} / {:.4}", mean.scan_to_mesh_cm, mean.nc)) }
                        }
                    }
                }
            }
        }
    }
}

fn by_part(residue: &Residue) -> Markup {
    let energies = residue.parts.iter().any(|part| part.energy.is_some());
    html! {
        h2 { "By part of the body" }
        table {
            tr {
                th {} th { "share of points" } th { "share of what normals lack" }
                @for name in STAGE_NAMES { th { (name) ", cm / NC" } }
                @if energies { th { "detail, 1/m" } th { "true detail, 1/m" } }
            }
            @for part in residue.parts.iter().filter(|part| part.share > 0.0) {
                tr {
                    th { (part.part.name()) }
                    td { (format!("{:.1} %", 100.0 * part.share)) }
                    td { (format!("{:.1} %", 100.0 * part.share_of_nc_loss)) }
                    @for stage in 0..3 {
                        td { (format!("{:.3} / {:.4}", part.scan_to_mesh_cm[stage], part.nc[stage])) }
                    }
                    @if let Some(energy) = part.energy {
                        td { (format!("{:.1}", energy.own_per_metre)) }
                        td { (format!("{:.1}", energy.true_per_metre)) }
                    }
                }
            }
        }
        @if energies {
            p { "Detail is the root mean square of the Laplacian of what lies between the base and a surface: the avatar's, and one fitted to the truth. A smooth surface may have good normals and little detail." }
        }
    }
}

fn pictures(report: &Report) -> Markup {
    html! {
        h2 { "What it looks like" }
        @match report.pictures {
            Err(why) => p { "No pictures: " (why) }
            Ok(rows) => {
                p {
                    "The hardest frames and a usual one, drawn with " (report.adapter) ". Error: red where the truth lies outside the mesh, blue where it lies inside, the whole colour at "
                    (format!("{:.0} cm.", 100.0 * WHOLE_SCALE_METRES))
                }
                div.pictures {
                    @for name in COLUMNS { span { (name) } }
                    @for row in rows {
                        @for (picture, name) in row.pictures.iter().zip(COLUMNS) {
                            img loading="lazy" alt=(format!("frame {}: {name}", row.frame)) title=(format!("frame {}", row.frame))
                                src=(format!("data:image/jpeg;base64,{}", BASE64_STANDARD.encode(picture)));
                        }
                    }
                }
            }
        }
    }
}

fn run(report: &Report) -> Markup {
    let stages: Vec<&Line> = report.log.iter().filter(|line| line.seconds.is_some()).collect();
    let mut titles: Vec<&str> = Vec::new();
    for line in report.log.iter().filter(|line| line.energy.is_some()) {
        if !titles.contains(&line.stage.as_str()) {
            titles.push(&line.stage);
        }
    }
    html! {
        h2 { "How it was made" }
        @if !stages.is_empty() {
            table {
                tr { th { "stage" } th { "seconds" } }
                @for line in stages { tr { th { (line.stage) } td { (format!("{:.0}", line.seconds.unwrap_or_default())) } } }
            }
        }
        @for title in titles {
            @let point = |line: &Line| Some((line.epoch? as f64, f64::from(line.energy?)));
            @let points = report.log.iter().filter(|line| line.stage == title).filter_map(point).collect();
            h3 { (title) }
            (chart(&Axes { x: "epoch", y: "energy", logarithmic: true }, &[Series { name: title, points, is_scatter: false }]))
        }
        table {
            @for (key, value) in &report.avatar.provenance {
                @if key != "options" { tr { th { (key) } td.text { (plain(value)) } } }
            }
        }
        @if let Some(config) = report.config {
            details { summary { "All options" } pre { (config) } }
        } @else if let Some(options) = report.avatar.provenance.get("options") {
            details { summary { "All options" } pre { (serde_json::to_string_pretty(options).unwrap_or_default()) } }
        }
    }
}

/// Text as it is, everything else as JSON.
fn plain(value: &serde_json::Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), ToOwned::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::Evaluation;
    use crate::residue::{BODY_PARTS, DetailEnergy, PartResidue};
    use crease::fixture::compact_avatar;

    fn measures(scan_to_mesh_cm: f64) -> Measures {
        Measures { scan_to_mesh_cm, mesh_to_scan_cm: 0.5, nc: 0.9 }
    }

    fn residue() -> Residue {
        let frame = |(frame, cm): (usize, f64)| FrameResidue {
            frame,
            pose_distance_degrees: Some(3.0 * frame as f32),
            stages: [measures(1.5), measures(cm + 0.1), measures(cm)],
        };
        let frames: Vec<FrameResidue> = [0.3, 0.7, 0.2].into_iter().enumerate().map(frame).collect();
        let energy = DetailEnergy { own_per_metre: 11.5, true_per_metre: 77.25 };
        let part = |part| PartResidue {
            part,
            share: 0.125,
            share_of_nc_loss: 0.125,
            scan_to_mesh_cm: [1.5, 0.5, 0.4],
            nc: [0.8, 0.9, 0.91],
            energy: Some(energy),
        };
        let evaluation = Evaluation { frames: 3, body: measures(1.5), base: measures(0.5), detailed: measures(0.4) };
        Residue { evaluation, frames, parts: BODY_PARTS.into_iter().map(part).collect() }
    }

    fn text(sequence: &str, pictures: Result<&[Row], &str>) -> String {
        let line = |epoch, energy, seconds| Line { stage: "training the base".into(), epoch, energy, seconds };
        page(&Report {
            avatar: &compact_avatar(),
            bytes: 3_630_000,
            sequence,
            against: "ground truth",
            residue: &residue(),
            liveliness: 1.0,
            pictures,
            adapter: "an adapter",
            log: &[line(Some(1), Some(2.0), None), line(Some(2), Some(0.5), None), line(None, None, Some(61.0))],
            config: Some("seed = 7"),
        })
    }

    #[test]
    fn a_page_tells_all_it_was_given_and_needs_no_other_file() {
        let pictures = [Row { frame: 1, pictures: std::array::from_fn(|_| vec![0xff, 0xd8]) }];
        let page = text("dancer", Ok(&pictures));
        for part in [
            "3.63 MB",
            "0.400",
            "shins",
            "11.5",
            "77.2",
            "an adapter",
            "data:image/jpeg;base64,/9g=",
            "61",
            "seed = 7",
            "liveliness 1: poses",
        ] {
            assert!(page.contains(part), "{part}");
        }
        assert_eq!(page.matches("<img").count(), COLUMNS.len());
        for outside in ["http:", "https:", "src=\"/", "<link", "<script"] {
            assert!(!page.contains(outside), "{outside}");
        }
    }

    #[test]
    fn the_hardest_frame_comes_first() {
        let order: Vec<usize> = hardest(&residue().frames).iter().map(|frame| frame.frame).collect();
        assert_eq!(order, [1, 0, 2]);
    }

    #[test]
    fn without_pictures_the_page_says_why() {
        assert!(text("dancer", Err("no adapter here")).contains("No pictures: no adapter here"));
    }

    #[test]
    fn names_are_text() {
        let page = text("<b>&", Err(""));
        assert!(page.contains("&lt;b&gt;&amp;") && !page.contains("<b>"));
    }
}

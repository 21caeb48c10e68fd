//! Line charts as SVG.

use maud::{Markup, html};

/// Size of a chart and of the frame that its axes leave, CSS pixels.
const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 240.0;
const LEFT: f64 = 56.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 12.0;
const BOTTOM: f64 = 36.0;

/// A line, or points, with a name.
pub struct Series<'a> {
    /// For the legend.
    pub name: &'a str,
    /// (x, y), in order of x.
    pub points: Vec<(f64, f64)>,
    /// Points alone, where x is no time.
    pub is_scatter: bool,
}

/// What the axes say, and how they count.
pub struct Axes<'a> {
    /// Below.
    pub x: &'a str,
    /// On the left.
    pub y: &'a str,
    /// Powers of ten on the left.
    pub logarithmic: bool,
}

/// A chart of finite numbers; nothing without any.
pub fn chart(axes: &Axes, series: &[Series]) -> Markup {
    let height_of = |y: f64| if axes.logarithmic { y.max(f64::MIN_POSITIVE).log10() } else { y };
    let all = || series.iter().flat_map(|series| &series.points);
    let (Some(x), Some(y)) = (range(all().map(|point| point.0)), range(all().map(|point| height_of(point.1)))) else {
        return html! {};
    };
    let across = |value: f64| LEFT + (WIDTH - LEFT - RIGHT) * (value - x.0) / (x.1 - x.0);
    let down = |value: f64| HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * (value - y.0) / (y.1 - y.0);
    let label = |value: f64| number(if axes.logarithmic { 10f64.powf(value) } else { value });
    html! {
        figure.chart {
            svg viewBox=(format!("0 0 {WIDTH} {HEIGHT}")) role="img" aria-label=(format!("{} over {}", axes.y, axes.x)) {
                @for value in ticks(y) {
                    line.grid x1=(LEFT) x2=(WIDTH - RIGHT) y1=(down(value)) y2=(down(value)) {}
                    text x=(LEFT - 6.0) y=(down(value) + 4.0) text-anchor="end" { (label(value)) }
                }
                @for value in ticks(x) {
                    text x=(across(value)) y=(HEIGHT - BOTTOM + 16.0) text-anchor="middle" { (number(value)) }
                }
                text x=((LEFT + WIDTH - RIGHT) / 2.0) y=(HEIGHT - 4.0) text-anchor="middle" { (axes.x) }
                @for (index, series) in series.iter().enumerate() {
                    @let colour = format!("series-{}", index % 4);
                    @if series.is_scatter {
                        @for point in &series.points {
                            circle class=(colour) cx=(across(point.0)) cy=(down(height_of(point.1))) r="3" {}
                        }
                    } @else {
                        polyline class=(colour) points=(polyline(series, |point| (across(point.0), down(height_of(point.1))))) {}
                    }
                }
            }
            figcaption {
                (axes.y) ": "
                @for (index, series) in series.iter().enumerate() {
                    span class=(format!("legend series-{}", index % 4)) { (series.name) }
                }
            }
        }
    }
}

fn polyline(series: &Series, place: impl Fn(&(f64, f64)) -> (f64, f64)) -> String {
    let corner = |point| {
        let (x, y) = place(point);
        format!("{x:.1},{y:.1}")
    };
    series.points.iter().map(corner).collect::<Vec<_>>().join(" ")
}

/// From the smallest to the largest, widened where they are one.
fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let finite: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    let least = finite.iter().copied().reduce(f64::min)?;
    let greatest = finite.iter().copied().reduce(f64::max)?;
    let width = greatest - least;
    Some(if width > 0.0 { (least, greatest) } else { (least - 0.5, greatest + 0.5) })
}

/// Round values within a range, three to seven of them.
fn ticks((least, greatest): (f64, f64)) -> Vec<f64> {
    let rough = (greatest - least) / 4.0;
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power).into_iter().find(|&step| step >= rough);
    let step = step.unwrap_or(rough);
    let first = (least / step).ceil() as i64;
    (first..).map(|index| index as f64 * step).take_while(|&value| value <= greatest + 1e-9 * step).collect()
}

fn number(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        let rounded = format!("{value:.3}");
        rounded.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        format!("{value:.1e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axes(logarithmic: bool) -> Axes<'static> {
        Axes { x: "frame", y: "distance, cm", logarithmic }
    }

    #[test]
    fn the_largest_value_is_at_the_top_and_the_smallest_at_the_bottom() {
        for logarithmic in [false, true] {
            let series = Series { name: "base", points: vec![(0.0, 0.1), (1.0, 10.0)], is_scatter: false };
            let text = chart(&axes(logarithmic), &[series]).into_string();
            let corners = format!("points=\"{LEFT:.1},{:.1} {:.1},{TOP:.1}\"", HEIGHT - BOTTOM, WIDTH - RIGHT);
            assert!(text.contains(&corners), "{text}");
        }
    }

    #[test]
    fn ticks_are_round_and_within() {
        assert_eq!(ticks((0.0, 1.0)), [0.0, 0.5, 1.0]);
        assert_eq!(ticks((3.0, 27.0)), [10.0, 20.0]);
        for (least, greatest) in [(0.26, 0.31), (-7.0, 1234.5)] {
            let ticks = ticks((least, greatest));
            assert!(
                (2..=7).contains(&ticks.len()) && ticks.iter().all(|t| (least..=greatest).contains(t)),
                "{ticks:?}"
            );
        }
    }

    #[test]
    fn nothing_and_one_point_are_no_trouble() {
        assert!(chart(&axes(false), &[]).into_string().is_empty());
        let one = Series { name: "a", points: vec![(3.0, 3.0)], is_scatter: true };
        assert!(chart(&axes(false), &[one]).into_string().contains("<circle"));
        let broken = Series { name: "a", points: vec![(0.0, f64::NAN)], is_scatter: false };
        assert!(chart(&axes(false), &[broken]).into_string().is_empty());
    }

    #[test]
    fn names_cannot_break_out_of_the_page() {
        let series = Series { name: "<script>", points: vec![(0.0, 1.0)], is_scatter: false };
        assert!(!chart(&axes(false), &[series]).into_string().contains("<script>"));
    }
}

//! Quality that follows the machine: which level is shown, from what the frames cost. Pure logic over measured times.

use crate::solver::Stop;

/// What a level of quality asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QualityLevel {
    /// Its name, for the page.
    pub name: &'static str,
    /// When the solver stops.
    pub stop: Stop,
    /// Levels below the finest on which the Laplacian is integrated.
    pub coarser_solve: usize,
    /// Levels below the finest of the mesh that is computed, whose positions and normals are drawn.
    pub coarser_surface: usize,
    /// Levels below that mesh of the triangles that are drawn: their corners are its vertices, and normals between them are interpolated.
    pub coarser_triangles: usize,
    /// Pixels of the picture a side, as a share of the screen's.
    pub pixel_share: f32,
    /// About how much work posing is, as a share of the best level's: estimated from the parts in docs/performance.md. `cargo xtask bench`
    /// measures each level (`quality_ms_native_…`).
    pub work: f64,
}

/// All levels, the best first. Neighbours look alike: before the mesh that is drawn gets coarser, its wrinkles have been solved on the coarser
/// one already, and the browser scales smaller pictures smoothly.
pub const QUALITY_LEVELS: [QualityLevel; 5] = [
    level("best", Stop::Tolerance(2e-5), [0, 0, 0], 1.0, 1.0),
    level("high", Stop::Iterations(2), [0, 0, 0], 1.0, 0.8),
    level("medium", Stop::Iterations(2), [1, 0, 0], 1.0, 0.5),
    level("low", Stop::Iterations(2), [1, 1, 0], 0.85, 0.35),
    level("lowest", Stop::Iterations(1), [1, 1, 1], 0.6, 0.3),
];

const fn level(
    name: &'static str,
    stop: Stop,
    [coarser_solve, coarser_surface, coarser_triangles]: [usize; 3],
    pixel_share: f32,
    work: f64,
) -> QualityLevel {
    QualityLevel { name, stop, coarser_solve, coarser_surface, coarser_triangles, pixel_share, work }
}

/// Seconds for which a level is kept at least.
const SHORTEST_STAY: f64 = 1.0;
/// Seconds after a change whose frames do not count: buffers and caches are made anew.
const SETTLE: f64 = 0.25;
/// Seconds of good frames before a better level is tried.
const CALM: f64 = 3.0;
/// Seconds for which a level that could not be held is not tried again; doubled each time.
const FIRST_BAN: f64 = 10.0;
const LONGEST_BAN: f64 = 640.0;
/// A frame is late when it took this many periods of the display. Pictures come at whole periods, so anything between one and two says
/// the same; this is their geometric mean.
const LATE: f64 = 1.4;
/// A better level is tried only where its work, as far as the present one's tells, would take less than this share of the period. The
/// rest is for the browser and for noise.
const ROOMY: f64 = 0.75;
/// Even the last level brings nothing where its intervals are no shorter than this share of the best one's: then the display is slow, or
/// the page, and quality would be lost for nothing.
const FUTILE: f64 = 0.93;
/// Medians are taken of as many frames at most and at least.
const WINDOW: usize = 24;
const FEWEST: usize = 5;
/// Displays are no slower and no faster than this, seconds a frame, as long as nothing tells otherwise.
const PERIODS: [f64; 2] = [1.0 / 240.0, 1.0 / 50.0];
/// A longer gap between frames is a pause, not a slow frame.
const PAUSE: f64 = 2.0;

/// Chooses one of [`QUALITY_LEVELS`] from frame times, one step at a time, and never to and fro.
#[derive(Clone, Debug)]
pub struct QualityController {
    level: usize,
    /// Seconds since the last change.
    stayed: f64,
    /// Seconds without a late median.
    calm: f64,
    /// Shortest interval seen lately: the display's period.
    period: f64,
    /// The longest period that a display may have.
    longest_period: f64,
    /// The median interval with which the best level was left.
    best_interval: f64,
    intervals: Vec<f64>,
    works: Vec<f64>,
    next: usize,
    /// For each level: seconds for which it is not tried again, and how long the next ban is.
    bans: [f64; QUALITY_LEVELS.len()],
    next_bans: [f64; QUALITY_LEVELS.len()],
}

impl Default for QualityController {
    /// Starts with the best level.
    fn default() -> Self {
        Self {
            level: 0,
            stayed: 0.0,
            calm: 0.0,
            period: PERIODS[1],
            longest_period: PERIODS[1],
            best_interval: f64::INFINITY,
            intervals: Vec::with_capacity(WINDOW),
            works: Vec::with_capacity(WINDOW),
            next: 0,
            bans: [0.0; QUALITY_LEVELS.len()],
            next_bans: [FIRST_BAN; QUALITY_LEVELS.len()],
        }
    }
}

impl QualityController {
    /// Index of the level to show.
    pub fn level(&self) -> usize {
        self.level
    }

    /// Takes one frame into account: seconds since the frame before it, and seconds of work that went into it. Returns the level to show.
    pub fn frame(&mut self, interval: f64, work: f64) -> usize {
        if !(interval > 0.0 && interval < PAUSE && work >= 0.0) {
            return self.level;
        }
        self.stayed += interval;
        for ban in &mut self.bans {
            *ban = (*ban - interval).max(0.0);
        }
        if self.stayed < SETTLE {
            return self.level;
        }
        // Creeps up slowly, so that a window on another display is noticed.
        self.period = (1.001 * self.period).min(interval).clamp(PERIODS[0], self.longest_period);
        self.remember(interval, work);
        if self.intervals.len() < FEWEST {
            return self.level;
        }
        let usual_interval = median(&self.intervals);
        let late = usual_interval > LATE * self.period;
        self.calm = if late { 0.0 } else { self.calm + interval };
        if self.stayed < SHORTEST_STAY {
            return self.level;
        }
        if late && self.level + 1 < QUALITY_LEVELS.len() {
            if self.level == 0 {
                self.best_interval = usual_interval;
            }
            self.ban(self.level);
            self.change(self.level + 1);
        } else if late && usual_interval >= FUTILE * self.best_interval {
            self.longest_period = usual_interval;
            self.period = usual_interval;
            self.best_interval = f64::INFINITY;
            self.bans = [0.0; QUALITY_LEVELS.len()];
            self.change(0);
        } else if self.calm >= CALM && self.level > 0 && self.bans[self.level - 1] == 0.0 && self.has_room() {
            self.change(self.level - 1);
        }
        self.level
    }

    /// Whether the next better level's work would fit into the display's period.
    fn has_room(&self) -> bool {
        let growth = QUALITY_LEVELS[self.level - 1].work / QUALITY_LEVELS[self.level].work;
        median(&self.works) * growth < ROOMY * self.period
    }

    fn remember(&mut self, interval: f64, work: f64) {
        if self.intervals.len() < WINDOW {
            self.intervals.push(interval);
            self.works.push(work);
        } else {
            self.intervals[self.next] = interval;
            self.works[self.next] = work;
        }
        self.next = (self.next + 1) % WINDOW;
    }

    fn ban(&mut self, level: usize) {
        self.bans[level] = self.next_bans[level];
        self.next_bans[level] = (2.0 * self.next_bans[level]).min(LONGEST_BAN);
    }

    fn change(&mut self, level: usize) {
        self.level = level;
        self.stayed = 0.0;
        self.calm = 0.0;
        self.next = 0;
        self.intervals.clear();
        self.works.clear();
    }
}

/// The middle one of a few numbers, the upper one of two; infinite without one.
fn median(numbers: &[f64]) -> f64 {
    let exceeds_half = |x: &f64| numbers.iter().filter(|y| *y <= x).count() > numbers.len() / 2;
    numbers.iter().copied().filter(exceeds_half).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A machine on which each level takes so many seconds of work, before a display of the given period.
    struct Machine {
        works: [f64; QUALITY_LEVELS.len()],
        period: f64,
        /// Each frame takes up to so many times its work longer, at random.
        noise: f64,
        /// Every so many frames one takes a tenth of a second longer.
        spike_every: usize,
    }

    impl Machine {
        /// Levels cost their shares of `best` seconds.
        fn new(best: f64, period: f64) -> Self {
            Self { works: QUALITY_LEVELS.map(|level| level.work * best), period, noise: 0.0, spike_every: usize::MAX }
        }

        /// Plays for `seconds`; returns when the level changed, and to what.
        fn play(&self, controller: &mut QualityController, seconds: f64) -> Vec<(f64, usize)> {
            let (mut time, mut changes, mut frame, mut state) = (0.0, Vec::new(), 0, 1u32);
            while time < seconds {
                frame += 1;
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let random = f64::from(state >> 8) / f64::from(1u32 << 24);
                let before = controller.level();
                let spike = if frame % self.spike_every == 0 { 0.1 } else { 0.0 };
                let work = self.works[before] * (1.0 + self.noise * random) + spike;
                let interval = (work / self.period).ceil().max(1.0) * self.period;
                time += interval;
                if controller.frame(interval, work) != before {
                    changes.push((time, controller.level()));
                }
            }
            changes
        }
    }

    const SIXTY: f64 = 1.0 / 60.0;

    #[test]
    fn a_fast_machine_keeps_the_best_level() {
        let mut controller = QualityController::default();
        assert_eq!(Machine::new(0.005, SIXTY).play(&mut controller, 60.0), []);
    }

    /// Of a machine on which every level but the last `holding` ones is too slow.
    fn held_by_the_last(holding: usize) -> Machine {
        let held = QUALITY_LEVELS[QUALITY_LEVELS.len() - holding].work;
        Machine::new(0.95 * SIXTY / held, SIXTY)
    }

    #[test]
    fn a_slow_machine_steps_down_one_by_one_until_it_holds_the_rate() {
        let mut controller = QualityController::default();
        let changes = held_by_the_last(3).play(&mut controller, 9.0);
        let levels: Vec<usize> = changes.iter().map(|change| change.1).collect();
        assert_eq!(levels, [1, 2]);
        assert!(changes[0].0 >= SHORTEST_STAY && changes[1].0 - changes[0].0 >= SHORTEST_STAY, "{changes:?}");
        assert!(changes[1].0 < 3.0 * SHORTEST_STAY, "it does not dawdle: {changes:?}");
    }

    #[test]
    fn a_level_that_just_holds_is_not_left_for_one_that_does_not() {
        let mut controller = QualityController::default();
        let changes = held_by_the_last(3).play(&mut controller, 600.0);
        assert_eq!(changes.len(), 2, "no room for a better level: {changes:?}");
    }

    #[test]
    fn a_very_slow_machine_is_at_its_last_level_within_seconds() {
        let mut controller = QualityController::default();
        let changes = Machine::new(0.6, SIXTY).play(&mut controller, 20.0);
        assert_eq!(controller.level(), QUALITY_LEVELS.len() - 1);
        assert!(changes.windows(2).all(|pair| pair[1].1 == pair[0].1 + 1), "one step at a time: {changes:?}");
        assert!(changes[changes.len() - 1].0 < 12.0, "{changes:?}");
    }

    #[test]
    fn a_spiky_machine_keeps_its_level() {
        for (noise, spike_every) in [(0.0, 20), (0.4, 20), (0.6, 7)] {
            let mut controller = QualityController::default();
            let machine = Machine { noise, spike_every, ..Machine::new(0.010, SIXTY) };
            assert_eq!(machine.play(&mut controller, 600.0), [], "noise {noise}, a spike in {spike_every}");
        }
    }

    #[test]
    fn noise_about_the_limit_makes_few_changes() {
        // The best level misses every other frame; the next one holds.
        let mut controller = QualityController::default();
        let machine = Machine { noise: 0.6, ..Machine::new(0.0128, SIXTY) };
        let changes = machine.play(&mut controller, 600.0);
        assert!(changes.len() <= 12, "{} changes in ten minutes: {changes:?}", changes.len());
    }

    #[test]
    fn a_slow_display_costs_no_quality() {
        // As phones do to save their battery: every other picture, however little there is to do.
        let mut controller = QualityController::default();
        let changes = Machine::new(0.004, 1.0 / 30.0).play(&mut controller, 600.0);
        assert_eq!(controller.level(), 0);
        assert!(changes.len() <= QUALITY_LEVELS.len(), "tried once: {changes:?}");
        assert!(changes[changes.len() - 1].0 < 10.0, "{changes:?}");
        // The saving ends, and later the machine gets slow: it is the display's new rate that is held.
        Machine::new(0.004, SIXTY).play(&mut controller, 5.0);
        Machine::new(0.030, SIXTY).play(&mut controller, 20.0);
        assert!(controller.level() > 0, "33 ms are two periods now");
    }

    #[test]
    fn trying_a_better_level_in_vain_gets_rarer() {
        // The second level has much room, the first one never fits.
        let machine = Machine { works: [0.030, 0.004, 0.003, 0.002, 0.001], ..Machine::new(0.0, SIXTY) };
        let mut controller = QualityController::default();
        let changes = machine.play(&mut controller, 600.0);
        let tries: Vec<f64> = changes.iter().filter(|change| change.1 == 0).map(|change| change.0).collect();
        assert!((2..=6).contains(&tries.len()), "{tries:?}");
        assert!(tries.windows(3).all(|t| t[2] - t[1] > 1.5 * (t[1] - t[0])), "{tries:?}");
    }

    #[test]
    fn quality_comes_back_when_the_machine_gets_fast() {
        let mut controller = QualityController::default();
        Machine::new(0.050, SIXTY).play(&mut controller, 20.0);
        assert_eq!(controller.level(), QUALITY_LEVELS.len() - 1);
        let changes = Machine::new(0.004, SIXTY).play(&mut controller, 120.0);
        assert_eq!(controller.level(), 0);
        assert!(changes.windows(2).all(|pair| pair[1].1 + 1 == pair[0].1), "one step at a time: {changes:?}");
        assert!(changes.windows(2).all(|pair| pair[1].0 - pair[0].0 >= CALM), "{changes:?}");
    }

    #[test]
    fn single_slow_frames_and_pauses_change_nothing() {
        let mut controller = QualityController::default();
        for frame in 0..2000 {
            let interval = match frame % 40 {
                0 => 0.1,
                1 => 1.0,
                2 => 5.0,
                _ => SIXTY,
            };
            assert_eq!(controller.frame(interval, 0.004), 0);
        }
        assert_eq!(controller.frame(f64::NAN, 0.0), 0);
    }
}

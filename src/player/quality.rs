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
    /// Levels below the finest of the mesh that is drawn.
    pub coarser_surface: usize,
    /// Pixels of the picture a side, as a share of the screen's.
    pub pixel_share: f32,
}

/// All levels, the best first. Neighbours look alike: before the mesh that is drawn gets coarser, its wrinkles have been solved on the coarser
/// one already, and the browser scales smaller pictures smoothly.
pub const QUALITY_LEVELS: [QualityLevel; 5] = [
    level("best", Stop::Tolerance(2e-5), 0, 0, 1.0),
    level("high", Stop::Iterations(2), 0, 0, 1.0),
    level("medium", Stop::Iterations(2), 1, 0, 1.0),
    level("low", Stop::Iterations(2), 1, 1, 0.85),
    level("lowest", Stop::Iterations(1), 1, 1, 0.6),
];

const fn level(
    name: &'static str,
    stop: Stop,
    coarser_solve: usize,
    coarser_surface: usize,
    pixel_share: f32,
) -> QualityLevel {
    QualityLevel { name, stop, coarser_solve, coarser_surface, pixel_share }
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
/// A frame this much longer than the display's period was late.
const LATE: f64 = 1.4;
/// A better level is tried only where the work takes less than this share of the period.
const ROOMY: f64 = 0.6;
/// Of this many frames the medians are taken.
const WINDOW: usize = 24;
/// Displays are no slower and no faster than this, seconds a frame.
const PERIODS: [f64; 2] = [1.0 / 240.0, 1.0 / 50.0];
/// A longer gap between frames is a pause, not a slow frame.
const PAUSE: f64 = 0.5;

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
        self.period = (1.001 * self.period).min(interval).clamp(PERIODS[0], PERIODS[1]);
        self.remember(interval, work);
        if self.intervals.len() < WINDOW {
            return self.level;
        }
        let late = median(&self.intervals) > LATE * self.period;
        self.calm = if late { 0.0 } else { self.calm + interval };
        if self.stayed < SHORTEST_STAY {
            return self.level;
        }
        if late && self.level + 1 < QUALITY_LEVELS.len() {
            self.ban(self.level);
            self.change(self.level + 1);
        } else if self.calm >= CALM
            && self.level > 0
            && self.bans[self.level - 1] == 0.0
            && median(&self.works) < ROOMY * self.period
        {
            self.change(self.level - 1);
        }
        self.level
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

/// The middle one of at most [`WINDOW`] numbers; the upper one of two.
fn median(numbers: &[f64]) -> f64 {
    let mut sorted = [f64::INFINITY; WINDOW];
    let sorted = &mut sorted[..numbers.len()];
    sorted.copy_from_slice(numbers);
    sorted.sort_unstable_by(f64::total_cmp);
    sorted[numbers.len() / 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A machine on which each level takes so many seconds of work, before a display of the given period.
    struct Machine {
        works: [f64; QUALITY_LEVELS.len()],
        period: f64,
    }

    impl Machine {
        /// Levels cost 1, 0.8, 0.6 … of `best` seconds.
        fn new(best: f64, period: f64) -> Self {
            let mut works = [best; QUALITY_LEVELS.len()];
            for (index, work) in works.iter_mut().enumerate() {
                *work *= 1.0 - 0.2 * index as f64;
            }
            Self { works, period }
        }

        /// Plays for `seconds`; returns when the level changed, and to what.
        fn play(&self, controller: &mut QualityController, seconds: f64) -> Vec<(f64, usize)> {
            let (mut time, mut changes) = (0.0, Vec::new());
            while time < seconds {
                let before = controller.level();
                let work = self.works[before];
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

    #[test]
    fn a_slow_machine_steps_down_one_by_one_until_it_holds_the_rate() {
        let mut controller = QualityController::default();
        // 27, 21.6, 16.2 ms: the third level fits.
        let changes = Machine::new(0.027, SIXTY).play(&mut controller, 9.0);
        let levels: Vec<usize> = changes.iter().map(|change| change.1).collect();
        assert_eq!(levels, [1, 2]);
        assert!(changes[0].0 >= SHORTEST_STAY && changes[1].0 - changes[0].0 >= SHORTEST_STAY, "{changes:?}");
    }

    #[test]
    fn a_level_that_just_holds_is_not_left_for_one_that_does_not() {
        let mut controller = QualityController::default();
        let changes = Machine::new(0.027, SIXTY).play(&mut controller, 600.0);
        assert_eq!(changes.len(), 2, "no room for a better level: {changes:?}");
    }

    #[test]
    fn trying_a_better_level_in_vain_gets_rarer() {
        // The second level has much room, the first one never fits.
        let machine = Machine { works: [0.030, 0.004, 0.003, 0.002, 0.001], period: SIXTY };
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
                1 => 5.0,
                _ => SIXTY,
            };
            assert_eq!(controller.frame(interval, 0.004), 0);
        }
        assert_eq!(controller.frame(f64::NAN, 0.0), 0);
    }
}

//! Whether a frame is shared out between threads.
//!
//! Threads help only where there are processors for them. A page does not hear how many are free: others may be at work, or two that count
//! may be one. So the player measures both.

/// After so many frames the other way is looked at again, …
const PERIOD: u32 = 90;
/// … for so many frames.
const LOOK: u32 = 3;

/// The first look comes sooner.
const FIRST_PERIOD: u32 = 30;

/// How much of the last frame goes into the mean of its way.
const NEWEST: f64 = 0.3;

/// The other way must be so much faster to be taken.
const CLEARLY: f64 = 0.95;

/// What frames took of late, each way.
#[derive(Clone, Debug)]
pub(super) struct Sharing {
    /// Mean seconds: of frames of one thread, and of shared ones.
    means: [Option<f64>; 2],
    /// Whether the faster way is to share.
    shares: bool,
    frame: u32,
}

impl Default for Sharing {
    /// Shares, until it is known better.
    fn default() -> Self {
        Self { means: [None; 2], shares: true, frame: PERIOD - FIRST_PERIOD }
    }
}

impl Sharing {
    /// Whether the next frame is to be shared.
    pub fn now(&self) -> bool {
        // At the end of a period: the first frames of all have everything to set up.
        let looks = self.frame % PERIOD >= PERIOD - LOOK;
        self.shares != looks
    }

    /// The frame that [`Self::now`] was asked for took so many seconds.
    pub fn count(&mut self, seconds: f64) {
        let mean = &mut self.means[usize::from(self.now())];
        *mean = Some(mean.map_or(seconds, |mean| mean + NEWEST * (seconds - mean)));
        self.frame = self.frame.wrapping_add(1);
        if self.frame.is_multiple_of(PERIOD)
            && let [Some(alone), Some(shared)] = self.means
        {
            let (this, other) = if self.shares { (shared, alone) } else { (alone, shared) };
            self.shares ^= other < CLEARLY * this;
            // The next look is to forget this one.
            self.means[usize::from(!self.shares)] = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How many of so many frames are shared, if a frame of one thread and a shared one take so many seconds.
    fn shared(sharing: &mut Sharing, frames: u32, seconds: [f64; 2]) -> u32 {
        let mut count = 0;
        for _ in 0..frames {
            let shares = sharing.now();
            count += u32::from(shares);
            sharing.count(seconds[usize::from(shares)]);
        }
        count
    }

    #[test]
    fn the_faster_way_is_taken_and_left_again() {
        let mut sharing = Sharing::default();
        assert_eq!(shared(&mut sharing, FIRST_PERIOD, [0.02, 0.01]), FIRST_PERIOD - LOOK);
        assert_eq!(shared(&mut sharing, PERIOD, [0.02, 0.01]), PERIOD - LOOK, "threads help");
        assert_eq!(shared(&mut sharing, PERIOD, [0.02, 0.04]), PERIOD - LOOK, "nobody has looked yet");
        assert_eq!(shared(&mut sharing, 5 * PERIOD, [0.02, 0.04]), 5 * LOOK, "they do harm");
        shared(&mut sharing, PERIOD, [0.02, 0.01]);
        assert_eq!(shared(&mut sharing, PERIOD, [0.02, 0.01]), PERIOD - LOOK, "they help again");
    }

    #[test]
    fn of_two_ways_that_are_alike_the_present_one_is_kept() {
        let mut sharing = Sharing::default();
        assert_eq!(shared(&mut sharing, FIRST_PERIOD, [0.0196, 0.02]), FIRST_PERIOD - LOOK);
        assert_eq!(shared(&mut sharing, 4 * PERIOD, [0.0196, 0.02]), 4 * (PERIOD - LOOK));
        shared(&mut sharing, PERIOD, [0.01, 0.02]);
        assert_eq!(shared(&mut sharing, 4 * PERIOD, [0.02, 0.0196]), 4 * LOOK);
    }
}

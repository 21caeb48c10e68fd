//! Media time: play, pause, seek, rate and loop, with the meaning that HTML's media elements give them.

/// Time within a motion. Starts paused at zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Clock {
    seconds: f64,
    duration: f64,
    rate: f64,
    playing: bool,
    looping: bool,
}

impl Default for Clock {
    fn default() -> Self {
        Self { seconds: 0.0, duration: 0.0, rate: 1.0, playing: false, looping: false }
    }
}

impl Clock {
    /// Seconds since the motion's start, 0 ..= duration.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// Length of the motion, seconds.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// A new motion of `duration` seconds, from its start. Whether it plays does not change.
    pub fn set_duration(&mut self, duration: f64) {
        self.duration = if duration.is_finite() { duration.max(0.0) } else { 0.0 };
        self.seconds = 0.0;
    }

    /// Media seconds per real second; negative runs backwards.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// Sets the rate; anything that is not finite is ignored.
    pub fn set_rate(&mut self, rate: f64) {
        if rate.is_finite() {
            self.rate = rate;
        }
    }

    /// Whether time starts again at an end.
    pub fn looping(&self) -> bool {
        self.looping
    }

    /// Sets whether time starts again at an end.
    pub fn set_looping(&mut self, looping: bool) {
        self.looping = looping;
    }

    /// Whether time runs.
    pub fn playing(&self) -> bool {
        self.playing
    }

    /// Whether time runs and there is a motion for it to run through.
    pub fn running(&self) -> bool {
        self.playing && self.duration > 0.0
    }

    /// Starts time; from the beginning if the motion has ended.
    pub fn play(&mut self) {
        if self.at_end() {
            self.seconds = if self.rate < 0.0 { self.duration } else { 0.0 };
        }
        self.playing = true;
    }

    /// Stops time where it is.
    pub fn pause(&mut self) {
        self.playing = false;
    }

    /// Goes to `seconds`, clamped to the motion; anything that is not a number is ignored.
    pub fn seek(&mut self, seconds: f64) {
        if !seconds.is_nan() {
            self.seconds = seconds.clamp(0.0, self.duration);
        }
    }

    /// Whether a motion that does not loop has come to its end.
    pub fn ended(&self) -> bool {
        !self.looping && self.at_end()
    }

    /// Lets `seconds` of real time pass, and returns whether the motion started over. At the end of a motion that does not loop, time
    /// stops. A loop stays where it is when a rate beyond all measure leaves no place to wrap to.
    pub fn advance(&mut self, seconds: f64) -> bool {
        if !self.running() || !seconds.is_finite() {
            return false;
        }
        let next = self.seconds + seconds * self.rate;
        if self.looping {
            if next.is_finite() {
                self.seconds = next.rem_euclid(self.duration);
            }
            self.seconds != next
        } else {
            self.seconds = next.clamp(0.0, self.duration);
            self.playing = !self.at_end();
            false
        }
    }

    fn at_end(&self) -> bool {
        let end = if self.rate < 0.0 { 0.0 } else { self.duration };
        self.duration > 0.0 && self.seconds == end
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clock(duration: f64) -> Clock {
        let mut clock = Clock::default();
        clock.set_duration(duration);
        clock
    }

    #[test]
    fn time_stands_until_play_and_after_pause() {
        let mut clock = clock(4.0);
        clock.advance(1.0);
        assert_eq!(clock.seconds(), 0.0);
        clock.play();
        clock.advance(1.0);
        assert_eq!(clock.seconds(), 1.0);
        clock.pause();
        clock.advance(1.0);
        assert_eq!(clock.seconds(), 1.0);
    }

    #[test]
    fn a_rate_beyond_all_measure_leaves_time_within_the_motion() {
        for (rate, end) in [(1e301, 4.0), (-1e301, 0.0)] {
            let mut clock = clock(4.0);
            clock.set_looping(true);
            clock.set_rate(rate);
            clock.play();
            let before = clock.seconds();
            clock.advance(1e10);
            assert_eq!(clock.seconds(), before);
            clock.set_looping(false);
            clock.seek(2.0);
            clock.advance(1e10);
            assert_eq!(clock.seconds(), end);
        }
    }

    #[test]
    fn a_loop_wraps_both_ways() {
        let mut clock = clock(4.0);
        clock.set_looping(true);
        clock.play();
        assert!(!clock.advance(1.0));
        assert!(clock.advance(8.5));
        assert!((clock.seconds() - 1.5).abs() < 1e-12);
        clock.set_rate(-1.0);
        clock.advance(2.0);
        assert!((clock.seconds() - 3.5).abs() < 1e-12);
        assert!(clock.playing() && !clock.ended());
    }

    #[test]
    fn without_a_loop_it_ends_stops_and_starts_over() {
        let mut clock = clock(4.0);
        clock.set_looping(false);
        clock.play();
        clock.advance(9.0);
        assert_eq!((clock.seconds(), clock.playing(), clock.ended()), (4.0, false, true));
        clock.play();
        assert_eq!((clock.seconds(), clock.playing(), clock.ended()), (0.0, true, false));
    }

    #[test]
    fn the_rate_scales_time() {
        let mut clock = clock(4.0);
        clock.set_rate(0.5);
        clock.set_rate(f64::NAN);
        clock.play();
        clock.advance(2.0);
        assert_eq!(clock.seconds(), 1.0);
    }

    #[test]
    fn seeking_is_clamped_and_keeps_the_state() {
        let mut clock = clock(4.0);
        clock.seek(9.0);
        assert_eq!((clock.seconds(), clock.playing()), (4.0, false));
        clock.seek(-1.0);
        assert_eq!(clock.seconds(), 0.0);
        clock.seek(f64::NAN);
        assert_eq!(clock.seconds(), 0.0);
    }

    #[test]
    fn a_new_motion_starts_at_its_beginning_and_keeps_playing() {
        let mut clock = clock(4.0);
        clock.play();
        clock.advance(3.0);
        clock.set_duration(2.0);
        assert_eq!((clock.seconds(), clock.duration(), clock.playing()), (0.0, 2.0, true));
    }

    #[test]
    fn nothing_to_play_stays_at_zero() {
        let mut clock = clock(0.0);
        clock.play();
        clock.advance(1.0);
        assert_eq!((clock.seconds(), clock.ended(), clock.running()), (0.0, false, false));
    }
}

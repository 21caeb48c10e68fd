//! What plays, and when.

use super::Viewer;
use crate::bindings::named;
use crate::motion::Motion;
use glam::Vec3;
use js_sys::Error;
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
impl Viewer {
    /// Forgets motions that were read and never played.
    #[wasm_bindgen(js_name = beginMotions)]
    pub fn begin_motions(&mut self) {
        self.coming.clear();
    }

    /// Reads one more motion, to be played after those read before; returns what the reader has to say about it.
    #[wasm_bindgen(js_name = readMotion)]
    pub fn read_motion(
        &mut self,
        bytes: &[u8],
        name: &str,
        frames_per_second: Option<f32>,
    ) -> Result<Vec<String>, Error> {
        let motion = Motion::read(bytes, name, frames_per_second).map_err(|error| named("motion", &error))?;
        let notes = motion.notes.clone();
        self.coming.push(motion);
        Ok(notes)
    }

    /// Plays the motions that were read, from the beginning; none goes back to the rest pose.
    #[wasm_bindgen(js_name = playMotions)]
    pub fn play_motions(&mut self) -> Result<(), Error> {
        let motions = std::mem::take(&mut self.coming);
        self.player.set_motions(motions).map_err(|error| named("motion", &error))
    }

    /// Seconds over which a motion fades into the next one; 0 cuts.
    #[wasm_bindgen(js_name = setCrossfade)]
    pub fn set_crossfade(&mut self, seconds: f64) {
        self.player.set_crossfade(seconds);
        self.redraw = true;
    }

    /// Which of the motions plays.
    #[wasm_bindgen(getter, js_name = motionIndex)]
    pub fn motion_index(&self) -> usize {
        self.player.timeline().map_or(0, |timeline| timeline.index(self.player.clock.seconds()))
    }

    /// Poses a second of the motion that plays; 0 without one.
    #[wasm_bindgen(getter, js_name = framesPerSecond)]
    pub fn frames_per_second(&self) -> f32 {
        self.player.timeline().map_or(0.0, |timeline| timeline.frames_per_second(self.player.clock.seconds()))
    }

    /// Shows a pose in place of the motions: axis-angle, radians, three numbers for each joint, and the root's translation in metres.
    #[wasm_bindgen(js_name = setPose)]
    pub fn set_pose(&mut self, rotations: Option<Vec<f32>>, translation: Option<Vec<f32>>) -> Result<(), Error> {
        let translation = match translation.as_deref() {
            Some(&[x, y, z]) => Some(Vec3::new(x, y, z)),
            Some(other) => {
                return Err(named("pose", &format!("translation: expected 3 numbers, found {}", other.len())));
            }
            None => None,
        };
        let set = self.player.set_live_pose(rotations.as_deref(), translation);
        set.map_err(|error| {
            named("pose", &format!("pose: expected {} numbers, found {}", 3 * error.expected, 3 * error.found))
        })?;
        self.redraw = true;
        Ok(())
    }

    /// Seconds in which a pose covers 63 % of the way to the one that was set last; 0 jumps.
    #[wasm_bindgen(js_name = setSmoothing)]
    pub fn set_smoothing(&mut self, seconds: f64) {
        self.player.set_smoothing(seconds);
    }

    /// Stops at `seconds` and shows them as they always look, whatever was before.
    #[wasm_bindgen(js_name = showExactly)]
    pub fn show_exactly(&mut self, seconds: f64) {
        self.player.show_exactly(seconds);
        self.redraw = true;
    }

    /// Starts time.
    pub fn play(&mut self) {
        self.player.clock.play();
    }

    /// Stops time; the picture that stands is made anew.
    pub fn pause(&mut self) {
        self.player.clock.pause();
        self.redraw = true;
    }

    /// Goes to a time of the motion, seconds.
    pub fn seek(&mut self, seconds: f64) {
        self.player.seek(seconds);
        self.redraw = true;
    }

    /// Media seconds per second.
    #[wasm_bindgen(js_name = setPlaybackRate)]
    pub fn set_playback_rate(&mut self, rate: f64) {
        self.player.clock.set_rate(rate);
    }

    /// Whether the motion starts over at its end.
    #[wasm_bindgen(getter)]
    pub fn looping(&self) -> bool {
        self.player.clock.looping()
    }

    /// Sets whether the motion starts over at its end.
    #[wasm_bindgen(js_name = setLoop)]
    pub fn set_loop(&mut self, looping: bool) {
        self.player.clock.set_looping(looping);
    }

    /// Seconds since the motion's start.
    #[wasm_bindgen(getter, js_name = currentTime)]
    pub fn current_time(&self) -> f64 {
        self.player.clock.seconds()
    }

    /// Length of the motion, seconds; 0 without one.
    #[wasm_bindgen(getter)]
    pub fn duration(&self) -> f64 {
        self.player.clock.duration()
    }

    /// Whether time runs.
    #[wasm_bindgen(getter)]
    pub fn playing(&self) -> bool {
        self.player.clock.playing()
    }

    /// Whether a motion that does not loop is over.
    #[wasm_bindgen(getter)]
    pub fn ended(&self) -> bool {
        self.player.clock.ended()
    }
}

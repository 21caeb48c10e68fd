//! Choices of frames as Python slices: `A::B`, `A:B:C`, or one number.

use std::str::FromStr;

/// `start:stop:step`; negative numbers count from the end, as in Python. A single number is that frame alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct FrameRange {
    start: Option<i64>,
    stop: Option<i64>,
    step: i64,
    single: bool,
}

/// Why a text is not a choice of frames.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("frames: expected {expected}, found {found}")]
pub struct FrameRangeError {
    expected: &'static str,
    found: String,
}

impl FrameRange {
    /// Every frame.
    pub const ALL: Self = Self { start: None, stop: None, step: 1, single: false };

    /// The chosen frames of a sequence of `count`, in order. An empty choice is an error.
    pub fn indices(self, count: usize) -> Result<Vec<usize>, FrameRangeError> {
        let count = count as i64;
        let from_end = |value: i64| if value < 0 { value + count } else { value };
        let indices: Vec<usize> = if self.single {
            let index = from_end(self.start.unwrap_or(0));
            (0..count).contains(&index).then_some(index as usize).into_iter().collect()
        } else {
            let start = from_end(self.start.unwrap_or(0)).clamp(0, count);
            let stop = from_end(self.stop.unwrap_or(count)).clamp(0, count);
            (start..stop).step_by(self.step as usize).map(|index| index as usize).collect()
        };
        if indices.is_empty() {
            return Err(FrameRangeError { expected: "at least one frame", found: format!("none of {count}") });
        }
        Ok(indices)
    }
}

impl FromStr for FrameRange {
    type Err = FrameRangeError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let error = |expected| FrameRangeError { expected, found: text.into() };
        let number = |part: &str| match part.trim() {
            "" => Ok(None),
            part => part.parse::<i64>().map(Some).map_err(|_| error("START:STOP:STEP, each a whole number or nothing")),
        };
        let parts: Vec<Option<i64>> = text.split(':').map(number).collect::<Result<_, _>>()?;
        match parts[..] {
            [Some(_)] => Ok(Self { start: parts[0], stop: None, step: 1, single: true }),
            [start, stop] => Ok(Self { start, stop, step: 1, single: false }),
            [start, stop, step] => match step.unwrap_or(1) {
                step if step > 0 => Ok(Self { start, stop, step, single: false }),
                _ => Err(error("a positive step")),
            },
            _ => Err(error("START:STOP:STEP")),
        }
    }
}

impl TryFrom<String> for FrameRange {
    type Error = FrameRangeError;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        text.parse()
    }
}

impl From<FrameRange> for String {
    fn from(range: FrameRange) -> Self {
        range.to_string()
    }
}

impl std::fmt::Display for FrameRange {
    fn fmt(&self, out: &mut std::fmt::Formatter) -> std::fmt::Result {
        let text = |number: Option<i64>| number.map(|number| number.to_string()).unwrap_or_default();
        match self.single {
            true => write!(out, "{}", text(self.start)),
            false => write!(
                out,
                "{}:{}:{}",
                text(self.start),
                text(self.stop),
                text(Some(self.step).filter(|&step| step != 1))
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn indices(text: &str, count: usize) -> Vec<usize> {
        text.parse::<FrameRange>().unwrap().indices(count).unwrap()
    }

    #[test]
    fn slices_are_pythons() {
        assert_eq!(indices("1::2", 6), [1, 3, 5]);
        assert_eq!(indices("0::4", 9), [0, 4, 8]);
        assert_eq!(indices("2:5", 9), [2, 3, 4]);
        assert_eq!(indices("1:8:3", 9), [1, 4, 7]);
        assert_eq!(indices("-3:", 9), [6, 7, 8]);
        assert_eq!(indices(":-7", 9), [0, 1]);
        assert_eq!(indices("::", 3), [0, 1, 2]);
        assert_eq!(indices("7:99", 9), [7, 8]);
        assert_eq!(indices("4", 9), [4]);
        assert_eq!(indices("-1", 9), [8]);
        assert_eq!(FrameRange::ALL.indices(2).unwrap(), [0, 1]);
    }

    #[test]
    fn ranges_print_as_they_are_written() {
        for text in ["1::2", "::", "2:5:", "-3::", "4"] {
            assert_eq!(text.parse::<FrameRange>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn nonsense_and_empty_choices_are_errors() {
        for text in ["", "a:b", "1:2:3:4", "::0", "::-1", "1.5"] {
            assert!(text.parse::<FrameRange>().is_err(), "{text}");
        }
        for text in ["5:5", "9:", "9", "-10"] {
            assert!(text.parse::<FrameRange>().unwrap().indices(9).is_err(), "{text}");
        }
    }
}

//! An array of any shape and element type.

/// A numpy array in C order (last index fastest), whatever its order in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Length of each dimension; empty for a single value.
    pub shape: Vec<usize>,
    /// The values, as many as the product of `shape`.
    pub elements: Elements,
}

/// Values of an array. Narrow types are widened, without loss: float16 to `F32`, all integers to 64 bits.
#[derive(Clone, Debug, PartialEq)]
pub enum Elements {
    /// float16 and float32.
    F32(Vec<f32>),
    /// float64.
    F64(Vec<f64>),
    /// int8 to int64.
    I64(Vec<i64>),
    /// uint8 to uint64.
    U64(Vec<u64>),
    /// bool.
    Bool(Vec<bool>),
    /// Byte strings (as Latin-1) and unicode strings, without numpy's padding.
    Text(Vec<String>),
}

impl Elements {
    /// How many.
    pub fn len(&self) -> usize {
        match self {
            Self::F32(values) => values.len(),
            Self::F64(values) => values.len(),
            Self::I64(values) => values.len(),
            Self::U64(values) => values.len(),
            Self::Bool(values) => values.len(),
            Self::Text(values) => values.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

macro_rules! elements_from {
    ($($element:ty => $variant:ident),*) => {$(
        impl From<Vec<$element>> for Elements {
            fn from(values: Vec<$element>) -> Self {
                Self::$variant(values)
            }
        }
    )*};
}
elements_from!(f32 => F32, f64 => F64, i64 => I64, u64 => U64, bool => Bool, String => Text);

impl Array {
    /// An array of `shape`, its values in C order.
    ///
    /// # Panics
    /// If there are not as many values as the shape holds.
    pub fn new(shape: &[usize], elements: impl Into<Elements>) -> Self {
        let elements = elements.into();
        assert_eq!(shape.iter().product::<usize>(), elements.len(), "values for shape {shape:?}");
        Self { shape: shape.to_vec(), elements }
    }

    /// As 64-bit floats; nothing for text.
    pub fn to_f64(&self) -> Option<Vec<f64>> {
        Some(match &self.elements {
            Elements::F32(values) => values.iter().map(|&x| f64::from(x)).collect(),
            Elements::F64(values) => values.clone(),
            Elements::I64(values) => values.iter().map(|&x| x as f64).collect(),
            Elements::U64(values) => values.iter().map(|&x| x as f64).collect(),
            Elements::Bool(values) => values.iter().map(|&x| f64::from(u8::from(x))).collect(),
            Elements::Text(_) => return None,
        })
    }

    /// As 32-bit floats, rounded; nothing for text.
    pub fn to_f32(&self) -> Option<Vec<f32>> {
        match &self.elements {
            Elements::F32(values) => Some(values.clone()),
            Elements::F64(values) => Some(values.iter().map(|&x| x as f32).collect()),
            _ => Some(self.to_f64()?.into_iter().map(|x| x as f32).collect()),
        }
    }

    /// As integers; nothing for text and where a value is not a whole number of 64 bits.
    pub fn to_i64(&self) -> Option<Vec<i64>> {
        match &self.elements {
            Elements::I64(values) => Some(values.clone()),
            Elements::U64(values) => values.iter().map(|&x| i64::try_from(x).ok()).collect(),
            // Beyond 2^53 a float no longer tells neighbouring integers apart.
            _ => (self.to_f64()?.into_iter())
                .map(|x| (x.fract() == 0.0 && x.abs() <= (1u64 << 53) as f64).then_some(x as i64))
                .collect(),
        }
    }

    /// As strings; nothing for numbers.
    pub fn to_text(&self) -> Option<&[String]> {
        match &self.elements {
            Elements::Text(values) => Some(values),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_floats_are_integers_and_others_are_not() {
        assert_eq!(Array::new(&[2], vec![3.0f32, -1.0]).to_i64(), Some(vec![3, -1]));
        assert_eq!(Array::new(&[1], vec![0.5f32]).to_i64(), None);
        assert_eq!(Array::new(&[1], vec![f64::NAN]).to_i64(), None);
        assert_eq!(Array::new(&[1], vec![1e300f64]).to_i64(), None);
        assert_eq!(Array::new(&[1], vec![u64::MAX]).to_i64(), None);
    }

    #[test]
    fn text_is_no_number() {
        let text = Array::new(&[1], vec!["1".to_owned()]);
        assert_eq!((text.to_f32(), text.to_f64(), text.to_i64()), (None, None, None));
        assert_eq!(text.to_text(), Some(&["1".to_owned()][..]));
    }
}

//! Sorting by whole numbers. The standard library's sort is compiled anew for every type, five kilobytes of a page's download each; what
//! does not run every frame shares this one.

/// Sorts `numbers`, ascending.
pub fn sort(numbers: &mut [u64]) {
    numbers.sort_unstable();
}

/// The places of `keys` in ascending order of the keys; places of the same key ascend.
pub fn places_by(keys: impl Iterator<Item = u32>) -> impl Iterator<Item = usize> {
    let mut numbers: Vec<u64> = keys.zip(0u64..).map(|(key, place)| u64::from(key) << 32 | place).collect();
    sort(&mut numbers);
    numbers.into_iter().map(|number| number as u32 as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_of_the_same_key_keep_their_order() {
        let keys = [7, u32::MAX, 0, 7, 3, 0];
        assert_eq!(places_by(keys.into_iter()).collect::<Vec<_>>(), [2, 5, 4, 0, 3, 1]);
    }
}

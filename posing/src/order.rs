//! Sorting by whole numbers. The standard library's sort is compiled anew for every type, and where it is compiled for size it is slow on
//! short lists.

/// Sorts a few numbers, ascending. What a vertex has around it is seldom more than a dozen, and nearly in order.
pub fn sort_few(numbers: &mut [u32]) {
    const FEW: usize = 32;
    if numbers.len() > FEW {
        return numbers.sort_unstable();
    }
    for end in 1..numbers.len() {
        let number = numbers[end];
        let mut at = end;
        while at > 0 && numbers[at - 1] > number {
            numbers[at] = numbers[at - 1];
            at -= 1;
        }
        numbers[at] = number;
    }
}

/// The places of `keys` in ascending order of the keys; places of the same key ascend.
pub fn places_by(keys: impl Iterator<Item = u32>) -> impl Iterator<Item = usize> {
    let mut numbers: Vec<u64> = keys.zip(0u64..).map(|(key, place)| u64::from(key) << 32 | place).collect();
    numbers.sort_unstable();
    numbers.into_iter().map(|number| number as u32 as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_and_many_numbers_come_in_order() {
        for count in [0, 1, 2, 7, 32, 33, 100] {
            let mut numbers: Vec<u32> = (0..count).map(|k: u32| k.wrapping_mul(0x9E37_79B9) >> 27).collect();
            let mut expected = numbers.clone();
            expected.sort();
            sort_few(&mut numbers);
            assert_eq!(numbers, expected);
        }
    }

    #[test]
    fn places_of_the_same_key_keep_their_order() {
        let keys = [7, u32::MAX, 0, 7, 3, 0];
        assert_eq!(places_by(keys.into_iter()).collect::<Vec<_>>(), [2, 5, 4, 0, 3, 1]);
    }
}

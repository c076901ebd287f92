//! Spelled: numbers in messages, as the author of a file may have written them.

/// Longer numbers are written with an exponent where that is shorter.
const LONG: usize = 12;

/// A number: `0.25`, and `1e300` for what has three hundred digits.
pub(crate) fn spelled(x: f64) -> String {
    let (plain, with_exponent) = (x.to_string(), format!("{x:e}"));
    if plain.len() > LONG && with_exponent.len() < plain.len() { with_exponent } else { plain }
}

/// Numbers in brackets.
pub(crate) fn listed(numbers: [f64; 3]) -> String {
    format!("[{}]", numbers.map(spelled).join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_numbers_have_an_exponent_and_others_are_as_they_are() {
        assert_eq!(
            [1e300, -1e-300, 0.25, 1e6, f64::INFINITY].map(spelled),
            ["1e300", "-1e-300", "0.25", "1000000", "inf"]
        );
        assert_eq!(spelled(0.1 + 0.2), "0.30000000000000004");
        assert_eq!(listed([0.0, 1e30, 0.5]), "[0, 1e30, 0.5]");
    }
}

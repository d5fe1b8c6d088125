//! Numbers in words: as many digits as say something, with a true minus sign.
//!
//! In: SI values. Out: short texts.

/// A value with three digits, or two when it is small; 0 for what is less than a millionth.
pub(crate) fn figure(value: f64) -> String {
    let size = value.abs();
    if size < 1e-6 {
        return "0".to_owned();
    }
    let place = size.log10().floor();
    let digits = if size < 0.1 { 1.0 - place } else { 2.0 - place };
    format!("{value:.0$}", digits.clamp(0.0, 7.0) as usize).replace('-', "−")
}

/// A position to a thousandth [rad or m].
pub(crate) fn position(value: f64) -> String {
    let text = format!("{value:.3}");
    if text == "-0.000" { "0.000".to_owned() } else { text.replace('-', "−") }
}

/// A length of `length` \[m\] with its unit.
pub(crate) fn metres(length: f64) -> String {
    let (value, unit) = if length < 0.0995 { (length * 1e3, "mm") } else { (length, "m") };
    let text = if value < 10.0 { format!("{value:.2}") } else { format!("{value:.0}") };
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    format!("{text} {unit}")
}

/// A duration of `seconds` \[s\].
pub(crate) fn duration(seconds: f64) -> String {
    if seconds < 0.1 {
        return format!("{:.0} ms", seconds * 1e3);
    }
    if seconds < 300.0 {
        return format!("{seconds:.2} s");
    }
    let minutes = (seconds / 60.0).floor();
    if minutes < 180.0 {
        return format!("{minutes:.0} min {:.0} s", (seconds - 60.0 * minutes).floor());
    }
    format!("{:.0} h {:.0} min", (minutes / 60.0).floor(), minutes % 60.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_the_digits_that_say_something() {
        let texts = [0.0, 0.5, -1.5712, 12.345, 4.21e-4, 1.2e-9, 123.4, 0.0312].map(figure);
        assert_eq!(texts, ["0", "0.500", "−1.57", "12.3", "0.00042", "0", "123", "0.031"]);
        assert_eq!([-1.2346, -1e-4].map(position), ["−1.235", "0.000"]);
    }

    #[test]
    fn lengths_and_durations_carry_their_units() {
        assert_eq!(
            [0.05, 0.0025, 0.5, 1.234, 20.0].map(metres),
            ["50 mm", "2.5 mm", "0.5 m", "1.23 m", "20 m"]
        );
        let texts = [0.002, 4.0, 3600.0, 10_810.0].map(duration);
        assert_eq!(texts, ["2 ms", "4.00 s", "60 min 0 s", "3 h 0 min"]);
    }
}

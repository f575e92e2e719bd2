//! Numbers as differences show them.

/// A number with 17 significant digits, which no other number shares.
pub(super) fn digits(value: f64) -> String {
    if value.is_nan() {
        return format!("NaN ({:#018x})", value.to_bits());
    }
    if value.is_infinite() {
        return value.to_string();
    }
    let scientific = format!("{value:.16e}");
    let exponent: i32 = scientific
        .split_once('e')
        .and_then(|(_, exponent)| exponent.parse().ok())
        .expect("scientific notation has an exponent");
    match exponent {
        -5..=16 => format!("{value:.*}", (16 - exponent) as usize),
        _ => scientific,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_17_digits() {
        let check = |value: f64, expected: &str| {
            assert_eq!(digits(value), expected);
            assert_eq!(expected.parse::<f64>().unwrap().to_bits(), value.to_bits());
        };
        check(7.40323366632768, "7.4032336663276803");
        check(-1234.5, "-1234.5000000000000");
        check(1e-5, "0.000010000000000000001");
        check(1e-6, "9.9999999999999995e-7");
        check(1e300, "1.0000000000000001e300");
        check(f64::INFINITY, "inf");
    }
}

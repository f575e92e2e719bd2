//! Numbers and text in a picture.

use std::fmt::{self, Write};

/// A length in the picture, pixels: always two decimals, never NaN.
#[derive(Clone, Copy)]
pub(super) struct Px(pub(super) f64);

impl fmt::Display for Px {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let hundredths = (self.0.clamp(-1e6, 1e6) * 100.0).round();
        // Neither NaN nor -0.00.
        let value = if hundredths.is_nan() || hundredths == 0.0 { 0.0 } else { hundredths / 100.0 };
        write!(f, "{value:.2}")
    }
}

/// Text that is safe between tags and within attributes.
pub(super) struct Escaped<'a>(pub(super) &'a str);

impl fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for character in self.0.chars() {
            match character {
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '&' => f.write_str("&amp;")?,
                '"' => f.write_str("&quot;")?,
                '\'' => f.write_str("&#39;")?,
                '\t' | '\n' | '\r' => f.write_char(' ')?,
                // XML 1.0 can't express these.
                '\u{0}'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => f.write_char('\u{fffd}')?,
                _ => f.write_char(character)?,
            }
        }
        Ok(())
    }
}

/// A number with up to four significant digits and no trailing zeros.
pub(super) fn significant(value: f64) -> String {
    if !value.is_finite() {
        return "unbounded".to_owned();
    }
    let size = value.abs();
    if size != 0.0 && !(1e-4..1e7).contains(&size) {
        return format!("{value:.2e}");
    }
    let whole = if size < 1.0 { 0 } else { libm::floor(libm::log10(size)) as usize + 1 };
    let leading =
        if size > 0.0 && size < 0.1 { libm::floor(-libm::log10(size)) as usize } else { 0 };
    let decimals = (4 + leading).saturating_sub(whole).min(7);
    let text = format!("{value:.decimals$}");
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    (if text == "-0" { "0" } else { text }).to_owned()
}

/// The approximate width of a text, pixels; an upper bound for common sans-serif fonts.
pub(super) fn width(text: &str, size: f64) -> f64 {
    let of = |character: char| match character {
        'i' | 'j' | 'l' | 't' | 'f' | 'r' | ' ' | '.' | ',' | ':' | ';' | '|' | '(' | ')' => 0.38,
        'm' | 'w' | 'M' | 'W' | '\u{2e80}'.. => 0.98,
        'A'..='Z' => 0.72,
        _ => 0.62,
    };
    text.chars().map(of).sum::<f64>() * size
}

/// Breaks text into at most `most` lines that are no wider than `room`, pixels.
pub(super) fn wrap(text: &str, size: f64, room: f64, most: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    let mut line = String::new();
    for word in text.split_whitespace() {
        for (index, piece) in broken(word, size, room).into_iter().enumerate() {
            let longer = format!("{line} {piece}");
            if line.is_empty() {
                line = piece;
            } else if index == 0 && width(&longer, size) <= room {
                line = longer;
            } else {
                lines.push(std::mem::replace(&mut line, piece));
            }
            if lines.len() == most {
                let last = lines.last_mut().expect("lines were pushed");
                last.push_str(" ...");
                return lines;
            }
        }
    }
    if !line.is_empty() {
        lines.push(line);
    }
    lines
}

/// A word in pieces that fit; nearly always the word itself.
fn broken(word: &str, size: f64, room: f64) -> Vec<String> {
    if width(word, size) <= room {
        return vec![word.to_owned()];
    }
    let most = ((room / size) as usize).max(4);
    let characters: Vec<char> = word.chars().collect();
    characters.chunks(most).map(|piece| piece.iter().collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_significant(value: f64, expected: &str) {
        assert_eq!(significant(value), expected);
    }

    #[test]
    fn numbers_have_four_significant_digits() {
        check_significant(6.919200165541185, "6.919");
        check_significant(29.365950690995216, "29.37");
        check_significant(0.01, "0.01");
        check_significant(0.012345, "0.01235");
        check_significant(0.9296875, "0.9297");
        check_significant(0.0, "0");
        check_significant(-0.00001, "-1.00e-5");
        check_significant(12345.6, "12346");
        check_significant(3e9, "3.00e9");
        check_significant(f64::INFINITY, "unbounded");
    }

    #[test]
    fn pixels_are_always_numbers() {
        let texts = [f64::NAN, f64::INFINITY, -0.001, 1.005].map(|value| Px(value).to_string());
        assert_eq!(texts, ["0.00", "1000000.00", "0.00", "1.00"]);
    }

    #[test]
    fn text_is_escaped() {
        let text = Escaped("<a href=\"x\">&'\u{1}\n").to_string();
        assert_eq!(text, "&lt;a href=&quot;x&quot;&gt;&amp;&#39;\u{fffd} ");
    }

    #[test]
    fn lines_fit_and_lose_no_word() {
        let text = "junction 1 is 2.40 m wide along x, the body needs more than 2.49 m";
        let lines = wrap(text, 12.0, 150.0, 20);
        assert!(lines.len() > 1);
        assert!(lines.iter().all(|line| width(line, 12.0) <= 150.0), "{lines:?}");
        assert_eq!(lines.join(" "), text);
    }

    #[test]
    fn too_long_text_ends_in_dots() {
        let lines = wrap(&"word ".repeat(500), 12.0, 150.0, 3);
        assert_eq!(lines.len(), 3);
        assert!(lines[2].ends_with(" ..."));
        let pieces = wrap(&"x".repeat(100), 12.0, 150.0, 20);
        assert_eq!(pieces.concat().len(), 100);
        assert!(pieces.iter().all(|line| width(line, 12.0) <= 150.0));
    }
}

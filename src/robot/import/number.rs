//! Parses numbers in the attributes of a description, and explains invalid ones.

/// Why a word is not a usable number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Fault {
    /// `inf`, `-Infinity`.
    Infinite,
    /// `nan`.
    Undefined,
    /// `0x1F`, which some parsers accept.
    Hexadecimal,
    /// `0,25`.
    Comma,
    /// Anything else.
    Other,
}

/// Parses a number.
pub(super) fn number(word: &str) -> Result<f64, Fault> {
    match word.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(number) if number.is_nan() => Err(Fault::Undefined),
        // A number that is too large is a separate fault.
        Ok(_) if word.contains(|letter: char| letter.is_ascii_digit()) => Err(Fault::Other),
        Ok(_) => Err(Fault::Infinite),
        Err(_) => Err(fault(word)),
    }
}

fn fault(word: &str) -> Fault {
    let unsigned = word.trim_start_matches(['+', '-']).to_ascii_lowercase();
    if unsigned.starts_with("0x") {
        Fault::Hexadecimal
    } else if unsigned
        .split_once(',')
        .is_some_and(|(whole, rest)| whole.parse::<f64>().is_ok() && !rest.is_empty())
    {
        Fault::Comma
    } else {
        Fault::Other
    }
}

impl Fault {
    /// The property that a number has and the word lacks.
    pub fn lacks(self) -> &'static str {
        match self {
            Self::Hexadecimal => "a decimal number",
            _ => "a finite number",
        }
    }

    pub fn help(self) -> &'static str {
        match self {
            Self::Infinite | Self::Undefined => {
                "write the figure itself, or leave the attribute out: a figure that is not known is a line \
                 to fill in"
            }
            Self::Hexadecimal => "write it as a decimal number",
            Self::Comma => "write a decimal point, and separate numbers by spaces",
            Self::Other => "write a number such as 0.25",
        }
    }

    /// Whether it is systematic in a file, so that one message is enough.
    pub fn is_habit(self) -> bool {
        self != Self::Other
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_that_are_no_numbers_are_told_apart() {
        assert_eq!(number("-1.5e-3"), Ok(-1.5e-3));
        for (word, fault) in [
            ("inf", Fault::Infinite),
            ("-Infinity", Fault::Infinite),
            ("NaN", Fault::Undefined),
            ("-0x1F", Fault::Hexadecimal),
            ("0,25", Fault::Comma),
            ("1e400", Fault::Other),
            ("heavy", Fault::Other),
            ("1.#INF", Fault::Other),
        ] {
            assert_eq!(number(word), Err(fault), "{word}");
        }
    }
}

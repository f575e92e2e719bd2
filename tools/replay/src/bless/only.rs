//! What `--only` names.

use comparison::check::Case;
use comparison::compare::Verdict;

/// Which replies are accepted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Only {
    Request(u64),
    Id(u64),
    Answers(Verdict),
}

impl std::str::FromStr for Only {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| {
            text.parse().map_err(|_| format!("{text:?} is not a whole number, 0 or greater"))
        };
        match text.split_once('=') {
            Some(("request", index)) => Ok(Self::Request(number(index)?)),
            Some(("id", id)) => Ok(Self::Id(number(id)?)),
            _ => {
                let verdicts =
                    [Verdict::Within, Verdict::Moved, Verdict::Appeared, Verdict::Vanished];
                let named = verdicts.into_iter().find(|verdict| verdict.name() == text);
                named.map(Self::Answers).ok_or_else(|| {
                    "must be request=N, id=ID, within, moved, appeared or vanished".to_owned()
                })
            }
        }
    }
}

impl Only {
    pub(crate) fn includes(self, case: &Case) -> bool {
        match self {
            Self::Request(index) => case.index == index,
            Self::Id(id) => case.id == Some(id),
            Self::Answers(verdict) => {
                case.comparison.answers.iter().any(|answer| answer.verdict == verdict)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_accepted_has_names() {
        assert_eq!("request=3".parse(), Ok(Only::Request(3)));
        assert_eq!("id=7".parse(), Ok(Only::Id(7)));
        assert_eq!("vanished".parse(), Ok(Only::Answers(Verdict::Vanished)));
        for text in ["equal", "3", "id=", "request=-1", "moved=1"] {
            assert!(text.parse::<Only>().is_err(), "{text}");
        }
    }
}

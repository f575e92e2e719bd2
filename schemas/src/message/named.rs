//! Enumerations whose values have names.

/// A closed set of values, each with the name that stands for it in JSON and in text.
pub(crate) trait Named: Copy + 'static {
    /// All values, in the order of their codes.
    const VALUES: &'static [Self];

    fn word(self) -> &'static str;

    fn from_word(word: &str) -> Option<Self>;

    /// What the value means, as its documentation says.
    #[cfg(feature = "json-schema")]
    fn meaning(self) -> &'static str;
}

/// Defines an enumeration together with the names of its values. This is the only
/// place where these names stand.
macro_rules! named {
    (
        $(#[$attribute:meta])*
        $visibility:vis enum $Type:ident {
            $($(#[doc = $doc:literal])+ $Value:ident = $name:literal,)+
        }
    ) => {
        $(#[$attribute])*
        $visibility enum $Type {
            $($(#[doc = $doc])+ $Value,)+
        }

        impl $Type {
            /// All values, in the order of their codes on the wire and in recordings.
            $visibility const ALL: &'static [Self] = &[$(Self::$Value,)+];

            /// The names of all values, in the same order.
            $visibility const NAMES: &'static [&'static str] = &[$($name,)+];

            /// The name used in JSON and in text.
            $visibility const fn name(self) -> &'static str {
                match self {
                    $(Self::$Value => $name,)+
                }
            }

            /// The value with this name.
            $visibility fn from_name(name: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|value| value.name() == name)
            }
        }

        impl std::fmt::Display for $Type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(self.name())
            }
        }

        impl $crate::message::Named for $Type {
            const VALUES: &'static [Self] = Self::ALL;

            fn word(self) -> &'static str {
                self.name()
            }

            fn from_word(word: &str) -> Option<Self> {
                Self::from_name(word)
            }

            #[cfg(feature = "json-schema")]
            fn meaning(self) -> &'static str {
                match self {
                    $(Self::$Value => concat!($($doc),+),)+
                }
            }
        }
    };
}

pub(crate) use named;

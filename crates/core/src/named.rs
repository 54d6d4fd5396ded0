//! Enumerations whose values have names: on the command line, in records and in text.

/// A value with a name.
pub trait Named: Copy + 'static {
    /// All values, in the order in which they are listed.
    const ALL: &'static [Self];

    /// The name used on the command line and in records.
    fn name(self) -> &'static str;

    /// The value of that name.
    fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|value| value.name() == name)
    }
}

/// Declares an enumeration whose values have names: [`Named`], `Display`, and serde's traits by name.
#[macro_export]
macro_rules! named {
    (
        $(#[$attribute:meta])*
        pub enum $enum:ident {
            $($(#[$of_value:meta])* $value:ident = $name:literal,)+
        }
    ) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum $enum {
            $($(#[$of_value])* $value,)+
        }

        impl $enum {
            /// All values, in the order in which they are listed.
            pub const ALL: &'static [Self] = &[$(Self::$value),+];

            /// The name used on the command line and in records.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$value => $name,)+
                }
            }
        }

        impl $crate::Named for $enum {
            const ALL: &'static [Self] = Self::ALL;

            fn name(self) -> &'static str {
                self.name()
            }
        }

        impl core::fmt::Display for $enum {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.pad(self.name())
            }
        }

        impl $crate::serde_core::Serialize for $enum {
            fn serialize<S: $crate::serde_core::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
                to.serialize_str(self.name())
            }
        }

        impl<'de> $crate::serde_core::Deserialize<'de> for $enum {
            fn deserialize<D: $crate::serde_core::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
                struct ByName;

                impl $crate::serde_core::de::Visitor<'_> for ByName {
                    type Value = $enum;

                    fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                        f.write_str(concat!("one of", $(" `", $name, "`"),+))
                    }

                    fn visit_str<E: $crate::serde_core::de::Error>(self, name: &str) -> Result<$enum, E> {
                        <$enum as $crate::Named>::named(name)
                            .ok_or_else(|| E::unknown_variant(name, &[$($name),+]))
                    }
                }

                from.deserialize_str(ByName)
            }
        }
    };
}

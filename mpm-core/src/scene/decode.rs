//! From the tables of a file to the types that they must have.
//!
//! A derived `Deserialize` would be compiled three times for each table, and keep a place in the file only as text of an error.

use std::collections::BTreeMap;
use std::ops::Range;

use toml::de::{DeArray, DeTable, DeValue};
use toml::{Spanned, Value};

/// A value that is not of the type that it must have, or a key that is missing or that no table has.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Misfit {
    /// Where in the file.
    pub span: Range<usize>,
    /// What is wrong.
    pub what: What,
}

/// What is wrong with a value.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum What {
    /// It has not this key.
    Missing(&'static str),
    /// It has a key that no table of its kind has.
    Unknown {
        /// "field" or "variant".
        kind: &'static str,
        /// The key.
        name: String,
        /// Those that there are.
        known: &'static [&'static str],
    },
    /// It is another value.
    Other {
        /// What there should be.
        expected: &'static str,
        /// What there is.
        found: String,
    },
}

/// A type that a value of a file may have.
pub(super) trait Decode: Sized {
    /// Reads a value at a place of the file.
    ///
    /// # Errors
    /// The first part of the value that does not fit.
    fn decode(value: &DeValue<'_>, span: &Range<usize>) -> Result<Self, Misfit>;

    /// What stands for a key that is not there, if it may be left out.
    fn absent() -> Option<Self> {
        None
    }
}

/// A value where another is expected.
fn other<T>(value: &DeValue<'_>, span: &Range<usize>, expected: &'static str) -> Result<T, Misfit> {
    let found = match value {
        DeValue::String(text) => format!("string {:?}", text.as_ref()),
        DeValue::Integer(number) => format!("integer `{number}`"),
        DeValue::Float(number) => format!("floating point `{number}`"),
        DeValue::Boolean(flag) => format!("boolean `{flag}`"),
        DeValue::Datetime(time) => format!("date `{time}`"),
        DeValue::Array(_) => "a list".to_owned(),
        DeValue::Table(_) => "a table".to_owned(),
    };
    Err(Misfit { span: span.clone(), what: What::Other { expected, found } })
}

impl<T: Decode> Decode for Spanned<T> {
    fn decode(value: &DeValue<'_>, span: &Range<usize>) -> Result<Self, Misfit> {
        T::decode(value, span).map(|inner| Self::new(span.clone(), inner))
    }
}

impl<T: Decode> Decode for Option<T> {
    fn decode(value: &DeValue<'_>, span: &Range<usize>) -> Result<Self, Misfit> {
        T::decode(value, span).map(Some)
    }

    fn absent() -> Option<Self> {
        Some(None)
    }
}

impl Decode for bool {
    fn decode(value: &DeValue<'_>, span: &Range<usize>) -> Result<Self, Misfit> {
        value.as_bool().map_or_else(|| other(value, span, "a boolean"), Ok)
    }
}

impl Decode for i64 {
    fn decode(value: &DeValue<'_>, span: &Range<usize>) -> Result<Self, Misfit> {
        let number = value.as_integer().and_then(|number| Self::from_str_radix(number.as_str(), number.radix()).ok());
        number.map_or_else(|| other(value, span, "a whole number"), Ok)
    }
}

impl Decode for f64 {
    fn decode(value: &DeValue<'_>, span: &Range<usize>) -> Result<Self, Misfit> {
        match value {
            DeValue::Float(number) => number.as_str().parse().ok(),
            DeValue::Integer(_) => i64::decode(value, span).ok().map(|whole| whole as Self),
            _ => None,
        }
        .map_or_else(|| other(value, span, "a number"), Ok)
    }
}

impl Decode for String {
    fn decode(value: &DeValue<'_>, span: &Range<usize>) -> Result<Self, Misfit> {
        value.as_str().map_or_else(|| other(value, span, "a string"), |text| Ok(text.to_owned()))
    }
}

/// The elements of a list.
fn list<T: Decode>(list: &DeArray<'_>) -> Result<Vec<T>, Misfit> {
    list.iter().map(|element| T::decode(element.get_ref(), &element.span())).collect()
}

impl<T: Decode> Decode for Vec<T> {
    fn decode(value: &DeValue<'_>, span: &Range<usize>) -> Result<Self, Misfit> {
        value.as_array().map_or_else(|| other(value, span, "a list"), list)
    }
}

impl Decode for [f64; 2] {
    fn decode(value: &DeValue<'_>, span: &Range<usize>) -> Result<Self, Misfit> {
        let expected = "a list of length 2";
        let numbers: Vec<f64> = value.as_array().map_or_else(|| other(value, span, expected), list)?;
        let found = format!("length {}", numbers.len());
        numbers.try_into().map_err(|_| Misfit { span: span.clone(), what: What::Other { expected, found } })
    }
}

impl Decode for Value {
    fn decode(value: &DeValue<'_>, span: &Range<usize>) -> Result<Self, Misfit> {
        Ok(match value {
            DeValue::String(text) => Self::String(text.to_string()),
            DeValue::Integer(_) => Self::Integer(i64::decode(value, span)?),
            DeValue::Float(_) => Self::Float(f64::decode(value, span)?),
            DeValue::Boolean(flag) => Self::Boolean(*flag),
            DeValue::Datetime(time) => Self::Datetime(*time),
            DeValue::Array(elements) => Self::Array(list(elements)?),
            DeValue::Table(table) => {
                let entry = |(key, value): (&Spanned<_>, &Spanned<DeValue<'_>>)| {
                    let key: &std::borrow::Cow<'_, str> = key.get_ref();
                    Ok((key.to_string(), Self::decode(value.get_ref(), &value.span())?))
                };
                Self::Table(table.iter().map(entry).collect::<Result<_, _>>()?)
            }
        })
    }
}

impl Decode for BTreeMap<String, Spanned<Value>> {
    fn decode(value: &DeValue<'_>, span: &Range<usize>) -> Result<Self, Misfit> {
        let mut all = Self::new();
        for (key, value) in table(value, span)? {
            all.insert(key.get_ref().to_string(), Decode::decode(value.get_ref(), &value.span())?);
        }
        Ok(all)
    }
}

/// The keys of a table.
pub(super) fn table<'t, 'i>(value: &'t DeValue<'i>, span: &Range<usize>) -> Result<&'t DeTable<'i>, Misfit> {
    value.as_table().map_or_else(|| other(value, span, "a table"), Ok)
}

/// A key that no table of its kind has.
pub(super) fn unknown<T>(
    kind: &'static str,
    name: &str,
    span: Range<usize>,
    known: &'static [&'static str],
) -> Result<T, Misfit> {
    Err(Misfit { span, what: What::Unknown { kind, name: name.to_owned(), known } })
}

/// What a key has been given, or what stands for it.
pub(super) fn given<T: Decode>(value: Option<T>, key: &'static str, span: &Range<usize>) -> Result<T, Misfit> {
    value.or_else(T::absent).ok_or_else(|| Misfit { span: span.clone(), what: What::Missing(key) })
}

/// The one key of a table that says which of several kinds it is, with its value.
pub(super) fn one_key<'t, 'i>(
    value: &'t DeValue<'i>,
    span: &Range<usize>,
    known: &'static [&'static str],
) -> Result<(&'t str, Range<usize>, &'t Spanned<DeValue<'i>>), Misfit> {
    if let Some(word) = value.as_str().filter(|word| !known.contains(word)) {
        return unknown("variant", word, span.clone(), known);
    } else if value.as_str().is_some() {
        return Err(Misfit {
            span: span.clone(),
            what: What::Other { expected: "a table", found: "a word".to_owned() },
        });
    }
    let table = table(value, span)?;
    let mut keys = table.iter();
    match (keys.next(), keys.next()) {
        (Some((key, value)), None) => Ok((key.get_ref(), key.span(), value)),
        _ => {
            let found = format!("{} keys", table.len());
            Err(Misfit { span: span.clone(), what: What::Other { expected: "a table with one key", found } })
        }
    }
}

/// Tables with their keys. Those of a type `Option` may be left out.
macro_rules! tables {
    ($($(#[$meta:meta])* $name:ident { $($key:ident: $type:ty,)* })*) => {$(
        $(#[$meta])*
        #[derive(Debug)]
        pub(super) struct $name {
            $(pub $key: $type,)*
        }

        impl $crate::scene::decode::Decode for $name {
            fn decode(value: &toml::de::DeValue<'_>, span: &std::ops::Range<usize>)
                -> Result<Self, $crate::scene::decode::Misfit>
            {
                use $crate::scene::decode;
                $(let mut $key: Option<$type> = None;)*
                for (key, value) in decode::table(value, span)? {
                    match key.get_ref().as_ref() {
                        $(stringify!($key) => {
                            $key = Some(decode::Decode::decode(value.get_ref(), &value.span())?);
                        })*
                        other => return decode::unknown("field", other, key.span(), &[$(stringify!($key)),*]),
                    }
                }
                Ok(Self { $($key: decode::given($key, stringify!($key), span)?,)* })
            }
        }
    )*};
}

/// Tables of one key that says which of several kinds they are.
macro_rules! kinds {
    ($($name:ident { $($key:literal => $kind:ident($table:ty),)* })*) => {$(
        #[derive(Debug)]
        pub(super) enum $name {
            $($kind($table),)*
        }

        impl $crate::scene::decode::Decode for $name {
            fn decode(value: &toml::de::DeValue<'_>, span: &std::ops::Range<usize>)
                -> Result<Self, $crate::scene::decode::Misfit>
            {
                use $crate::scene::decode;
                const KNOWN: &[&str] = &[$($key),*];
                let (key, place, value) = decode::one_key(value, span, KNOWN)?;
                match key {
                    $($key => decode::Decode::decode(value.get_ref(), &value.span()).map(Self::$kind),)*
                    other => decode::unknown("variant", other, place, KNOWN),
                }
            }
        }
    )*};
}

pub(super) use {kinds, tables};

//! Options of casters, as they are written behind a name: `volume?interval=0.5&threshold=100`.

use crate::CastError;
use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// One option of a caster, for help texts.
#[derive(Clone, Copy, Debug)]
pub struct CasterOption {
    /// Its name.
    pub name: &'static str,
    /// What it means, the values it can have, and the default.
    pub meaning: &'static str,
}

/// The options given for one caster.
pub(crate) struct Options<'a> {
    caster: &'static str,
    given: Vec<(&'a str, &'a str)>,
}

impl<'a> Options<'a> {
    /// Reads `key=value&key=value`.
    pub(crate) fn parse(
        caster: &'static str,
        known: &[CasterOption],
        text: &'a str,
    ) -> Result<Self, CastError> {
        let mut given: Vec<(&str, &str)> = Vec::new();
        for pair in text.split('&').filter(|pair| !pair.is_empty()) {
            let (key, value) = pair.split_once('=').unwrap_or((pair, ""));
            if !known.iter().any(|option| option.name == key) {
                let names: Vec<_> = known.iter().map(|option| option.name).collect();
                return Err(CastError::UnknownOption {
                    caster,
                    option: key.to_owned(),
                    known: if names.is_empty() {
                        "it has none".to_owned()
                    } else {
                        format!("it has {}", names.join(", "))
                    },
                });
            }
            if given.iter().any(|&(other, _)| other == key) {
                return Err(CastError::BadValue {
                    caster,
                    option: key.to_owned(),
                    value: value.to_owned(),
                    expected: "given once".to_owned(),
                });
            }
            given.push((key, value));
        }
        Ok(Self { caster, given })
    }

    fn value(&self, option: &str) -> Option<&'a str> {
        let find = |&&(key, _): &&(&str, &str)| key == option;
        self.given.iter().find(find).map(|&(_, value)| value)
    }

    fn bad(&self, option: &str, value: &str, expected: String) -> CastError {
        CastError::BadValue {
            caster: self.caster,
            option: option.to_owned(),
            value: value.to_owned(),
            expected,
        }
    }

    /// A number within `range`, or `None` where it is not given.
    pub(crate) fn number<N: FromStr + PartialOrd + Display>(
        &self,
        option: &str,
        range: RangeInclusive<N>,
    ) -> Result<Option<N>, CastError> {
        let parse = |text: &str| {
            let number = text.parse().ok().filter(|number| range.contains(number));
            number.ok_or_else(|| {
                let expected = format!("a number from {} to {}", range.start(), range.end());
                self.bad(option, text, expected)
            })
        };
        self.value(option).map(parse).transpose()
    }

    /// One of some words' meanings; the first word's where it is not given.
    pub(crate) fn choice<V: Copy>(
        &self,
        option: &str,
        choices: &[(&str, V)],
    ) -> Result<V, CastError> {
        let Some(text) = self.value(option) else {
            return Ok(choices[0].1);
        };
        let found = choices.iter().find(|(word, _)| *word == text);
        found.map(|&(_, meaning)| meaning).ok_or_else(|| {
            let words: Vec<_> = choices.iter().map(|(word, _)| *word).collect();
            self.bad(option, text, words.join(" or "))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOWN: [CasterOption; 2] = [
        CasterOption {
            name: "interval",
            meaning: "",
        },
        CasterOption {
            name: "blend",
            meaning: "",
        },
    ];

    #[test]
    fn options_are_read_and_faults_are_named() {
        let parse = |text| Options::parse("test", &KNOWN, text);
        let options = parse("interval=0.5&blend=off").unwrap();
        assert_eq!(options.number("interval", 0.1..=2.0), Ok(Some(0.5)));
        let words = [("on", true), ("off", false)];
        assert_eq!(options.choice("blend", &words), Ok(false));
        assert_eq!(parse("").unwrap().choice("blend", &words), Ok(true));
        assert_eq!(parse("").unwrap().number("interval", 0..=2), Ok(None));
        let error = |text| parse(text).map(|_| ()).unwrap_err().to_string();
        assert_eq!(
            error("step=1"),
            "test has no option \"step\": it has interval, blend"
        );
        assert!(error("blend=on&blend=on").contains("given once"));
        let options = parse("interval=nan&blend").unwrap();
        assert_eq!(
            options
                .number("interval", 0.1..=2.0)
                .unwrap_err()
                .to_string(),
            "test: interval = \"nan\", but it must be a number from 0.1 to 2"
        );
        assert!(options.choice("blend", &words).is_err());
    }
}

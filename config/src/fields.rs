//! Reading TOML tables with the place of every value at hand.
//!
//! A table hands out its values by key and remembers which were asked for, so that what is left
//! over at the end is unknown. Nothing here knows what a rig is.

use crate::RigError;
use crate::beside::Beside;
use std::cell::RefCell;
use std::ops::RangeInclusive;
use std::time::Duration;
use time::{Date, Month};
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use toml::value::Datetime;

/// A file's text, by which places become lines, and where the files are that it names.
#[derive(Clone, Copy)]
pub(crate) struct Source<'a> {
    pub(crate) file: &'a str,
    pub(crate) text: &'a str,
    pub(crate) beside: Beside<'a>,
}

impl Source<'_> {
    /// What a parser stumbled over.
    pub(crate) fn syntax(&self, error: &toml::de::Error) -> RigError {
        RigError::Syntax {
            file: self.file.to_owned(),
            line: self.line(error.span().map_or(0, |span| span.start)),
            problem: error.message().to_owned(),
        }
    }

    /// The line, from 1, of a byte of the text.
    pub(crate) fn line(&self, byte: usize) -> usize {
        let until = byte.min(self.text.len());
        1 + self.text.as_bytes()[..until]
            .iter()
            .filter(|&&b| b == b'\n')
            .count()
    }

    fn invalid(&self, byte: usize, key: &str, problem: &str, remedy: &str) -> RigError {
        RigError::Invalid {
            file: self.file.to_owned(),
            line: self.line(byte),
            key: key.to_owned(),
            problem: problem.to_owned(),
            remedy: remedy.to_owned(),
        }
    }
}

/// A table whose keys are being read.
pub(crate) struct Fields<'a> {
    source: Source<'a>,
    path: String,
    start: usize,
    table: &'a DeTable<'a>,
    asked: RefCell<Vec<String>>,
}

impl<'a> Fields<'a> {
    /// The file's outermost table.
    pub(crate) fn root(source: Source<'a>, table: &'a DeTable<'a>) -> Self {
        Self {
            source,
            path: String::new(),
            start: 0,
            table,
            asked: RefCell::default(),
        }
    }

    fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() {
            key.to_owned()
        } else {
            format!("{}.{key}", self.path)
        }
    }

    /// The value of `key`, if it is there.
    pub(crate) fn get(&self, key: &str) -> Option<Value<'a>> {
        self.asked.borrow_mut().push(key.to_owned());
        let (_, value) = self.table.iter().find(|(k, _)| k.get_ref() == key)?;
        Some(Value {
            source: self.source,
            path: self.path_of(key),
            value,
        })
    }

    /// The meaning of `key`'s word, one of `choices`; `default` where it is not there.
    pub(crate) fn choice_or<T: Copy>(
        &self,
        key: &str,
        default: T,
        choices: &[(&str, T)],
    ) -> Result<T, RigError> {
        self.get(key)
            .map_or(Ok(default), |value| value.choice(choices))
    }

    /// The day that `key` names, if it is there.
    pub(crate) fn date(&self, key: &str) -> Result<Option<Date>, RigError> {
        self.get(key).map(|value| value.date()).transpose()
    }

    /// The value of `key`; `remedy` says what to write where it is missing.
    pub(crate) fn need(&self, key: &str, remedy: &str) -> Result<Value<'a>, RigError> {
        match self.get(key) {
            Some(value) => Ok(value),
            None => {
                // A misspelt key is the likeliest reason that this one is missing.
                if let Some(unknown) = self.misspelling(key) {
                    return Err(unknown);
                }
                Err(self.error(key, "is missing", remedy))
            }
        }
    }

    /// The seconds at `key`, or `default` of them where it is not there.
    pub(crate) fn seconds(
        &self,
        key: &str,
        default: f64,
        range: RangeInclusive<f64>,
    ) -> Result<Duration, RigError> {
        let seconds = match self.get(key) {
            Some(value) => value.number(range, "seconds")?,
            None => default,
        };
        Ok(Duration::from_secs_f64(seconds))
    }

    /// Whether `key` is true, or `default` where it is not there.
    pub(crate) fn flag(&self, key: &str, default: bool) -> Result<bool, RigError> {
        self.get(key).map_or(Ok(default), |value| value.boolean())
    }

    /// An error at this table that names `key`.
    pub(crate) fn error(&self, key: &str, problem: &str, remedy: &str) -> RigError {
        self.source
            .invalid(self.start, &self.path_of(key), problem, remedy)
    }

    /// The table's keys, in the file's order.
    pub(crate) fn keys(&self) -> Vec<String> {
        let mut keys: Vec<_> = self
            .table
            .keys()
            .map(|k| (k.span().start, k.get_ref().to_string()))
            .collect();
        keys.sort();
        keys.into_iter().map(|(_, key)| key).collect()
    }

    /// Fails on the first key that nothing asked for.
    pub(crate) fn finish(self) -> Result<(), RigError> {
        let asked = self.asked.borrow();
        let mut unknown: Vec<_> = self
            .table
            .keys()
            .filter(|k| !asked.iter().any(|a| a == k.get_ref()))
            .collect();
        unknown.sort_by_key(|k| k.span().start);
        let Some(key) = unknown.first() else {
            return Ok(());
        };
        let known: Vec<&str> = asked.iter().map(String::as_str).collect();
        let remedy = match nearest(key.get_ref(), &known) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("known here: {}", known.join(", ")),
        };
        Err(self.source.invalid(
            key.span().start,
            &self.path_of(key.get_ref()),
            "is unknown",
            &remedy,
        ))
    }

    fn misspelling(&self, key: &str) -> Option<RigError> {
        let asked = self.asked.borrow();
        self.table
            .keys()
            .filter(|k| !asked.iter().any(|a| a == k.get_ref()))
            .find(|k| nearest(k.get_ref(), &[key]).is_some())
            .map(|found| {
                self.source.invalid(
                    found.span().start,
                    &self.path_of(found.get_ref()),
                    "is unknown",
                    &format!("did you mean `{key}`?"),
                )
            })
    }
}

/// One value and its place.
pub(crate) struct Value<'a> {
    source: Source<'a>,
    path: String,
    value: &'a Spanned<DeValue<'a>>,
}

impl<'a> Value<'a> {
    /// An error at this value.
    pub(crate) fn error(&self, problem: &str, remedy: &str) -> RigError {
        self.source
            .invalid(self.value.span().start, &self.path, problem, remedy)
    }

    /// An error at this value, which is of another type than what is wanted.
    pub(crate) fn wrong_type(&self, wanted: &str) -> RigError {
        let found = match self.value.get_ref() {
            DeValue::String(_) => "is a string",
            DeValue::Integer(_) | DeValue::Float(_) => "is a number",
            DeValue::Boolean(_) => "is true or false",
            DeValue::Datetime(_) => "is a date",
            DeValue::Array(_) => "is an array",
            DeValue::Table(_) => "is a table",
        };
        self.error(found, &format!("write {wanted}"))
    }

    /// A finite number within `range`, in `unit`.
    pub(crate) fn number(&self, range: RangeInclusive<f64>, unit: &str) -> Result<f64, RigError> {
        let wanted = format!("a number from {} to {} {unit}", range.start(), range.end());
        let wanted = wanted.trim_end();
        let number: Option<f64> = match self.value.get_ref() {
            DeValue::Float(float) => float.as_str().parse().ok(),
            DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix())
                .ok()
                .map(|i| i as f64),
            _ => return Err(self.wrong_type(wanted)),
        };
        match number {
            Some(number) if range.contains(&number) => Ok(number),
            _ => Err(self.error(&format!("is {}", self.shown()), &format!("write {wanted}"))),
        }
    }

    /// A whole number within `range`, in `unit`.
    pub(crate) fn integer(&self, range: RangeInclusive<u32>, unit: &str) -> Result<u32, RigError> {
        let wanted = format!(
            "a whole number from {} to {} {unit}",
            range.start(),
            range.end()
        );
        let wanted = wanted.trim_end();
        let DeValue::Integer(integer) = self.value.get_ref() else {
            return Err(self.wrong_type(wanted));
        };
        match u32::from_str_radix(integer.as_str(), integer.radix()) {
            Ok(number) if range.contains(&number) => Ok(number),
            _ => Err(self.error(&format!("is {}", self.shown()), &format!("write {wanted}"))),
        }
    }

    /// A number that is one of `choices`, in `unit`.
    pub(crate) fn one_of(&self, choices: &[u32], unit: &str) -> Result<u32, RigError> {
        let list = or_list(&choices.iter().map(u32::to_string).collect::<Vec<_>>());
        let wanted = format!("{list} {unit}");
        let wanted = wanted.trim_end();
        let DeValue::Integer(integer) = self.value.get_ref() else {
            return Err(self.wrong_type(wanted));
        };
        u32::from_str_radix(integer.as_str(), integer.radix())
            .ok()
            .filter(|number| choices.contains(number))
            .ok_or_else(|| self.error(&format!("is {}", self.shown()), &format!("write {wanted}")))
    }

    /// `true` or `false`.
    pub(crate) fn boolean(&self) -> Result<bool, RigError> {
        match self.value.get_ref() {
            DeValue::Boolean(value) => Ok(*value),
            _ => Err(self.wrong_type("true or false")),
        }
    }

    /// A day.
    fn date(&self) -> Result<Date, RigError> {
        let wanted = "a date such as 2026-11-21";
        let DeValue::Datetime(written) = self.value.get_ref() else {
            return Err(self.wrong_type(wanted));
        };
        day_of(written)
            .ok_or_else(|| self.error(&format!("is {}", self.shown()), &format!("write {wanted}")))
    }

    /// Where the files are that the text names.
    pub(crate) fn beside(&self) -> Beside<'a> {
        self.source.beside
    }

    /// Whether the text is a recording's.
    pub(crate) fn is_recorded(&self) -> bool {
        matches!(self.source.beside, Beside::Recorded(_))
    }

    /// A string; `wanted` says of what.
    pub(crate) fn text(&self, wanted: &str) -> Result<&'a str, RigError> {
        match self.value.get_ref() {
            DeValue::String(text) => Ok(text),
            _ => Err(self.wrong_type(&format!("{wanted}, in quotes"))),
        }
    }

    /// The meaning of a word that is one of `choices`.
    pub(crate) fn choice<T: Copy>(&self, choices: &[(&str, T)]) -> Result<T, RigError> {
        let words: Vec<&str> = choices.iter().map(|(word, _)| *word).collect();
        let list = or_list(&words);
        let text = self.text(&format!("one of {list}"))?;
        self.word(text, choices)
    }

    /// The meaning of `text`, a word of this value that is one of `choices`.
    pub(crate) fn word<T: Copy>(&self, text: &str, choices: &[(&str, T)]) -> Result<T, RigError> {
        let words: Vec<&str> = choices.iter().map(|(word, _)| *word).collect();
        let list = or_list(&words);
        if let Some((_, meaning)) = choices.iter().find(|(word, _)| *word == text) {
            return Ok(*meaning);
        }
        let remedy = match nearest(text, &words) {
            Some(near) => format!("did you mean \"{near}\"? Known: {list}"),
            None => format!("write {list}"),
        };
        Err(self.error(&format!("is {text:?}"), &remedy))
    }

    /// The values of an array, however many; `wanted` says what they are.
    pub(crate) fn elements(&self, wanted: &str) -> Result<Vec<Value<'a>>, RigError> {
        let DeValue::Array(array) = self.value.get_ref() else {
            return Err(self.wrong_type(wanted));
        };
        let element = |(i, value)| Value {
            source: self.source,
            path: format!("{}[{i}]", self.path),
            value,
        };
        Ok(array.iter().enumerate().map(element).collect())
    }

    /// `N` values in an array; `wanted` says what they are.
    pub(crate) fn array<const N: usize>(&self, wanted: &str) -> Result<[Value<'a>; N], RigError> {
        let values = self.elements(wanted)?;
        let found = values.len();
        <[Value<'a>; N]>::try_from(values)
            .map_err(|_| self.error(&format!("has {found} elements"), &format!("write {wanted}")))
    }

    /// `N` finite numbers within `range`, in `unit`.
    pub(crate) fn numbers<const N: usize>(
        &self,
        range: RangeInclusive<f64>,
        unit: &str,
    ) -> Result<[f64; N], RigError> {
        let values = self.array::<N>(format!("an array of {N} numbers {unit}").trim_end())?;
        let mut numbers = [0.0; N];
        for (number, value) in numbers.iter_mut().zip(&values) {
            *number = value.number(range.clone(), unit)?;
        }
        Ok(numbers)
    }

    /// Whether it is a table.
    pub(crate) fn is_table(&self) -> bool {
        matches!(self.value.get_ref(), DeValue::Table(_))
    }

    /// A table within.
    pub(crate) fn fields(&self) -> Result<Fields<'a>, RigError> {
        match self.value.get_ref() {
            DeValue::Table(table) => Ok(Fields {
                source: self.source,
                path: self.path.clone(),
                start: self.value.span().start,
                table,
                asked: RefCell::default(),
            }),
            _ => Err(self.wrong_type("a table")),
        }
    }

    fn shown(&self) -> &'a str {
        let span = self.value.span();
        self.source.text.get(span).unwrap_or("unreadable")
    }
}

/// The day that is written without a time, if it is in the calendar.
pub(crate) fn day_of(written: &Datetime) -> Option<Date> {
    let date = written.date.filter(|_| written.time.is_none())?;
    let month = Month::try_from(date.month).ok()?;
    Date::from_calendar_date(i32::from(date.year), month, date.day).ok()
}

/// `a, b or c`.
pub(crate) fn or_list<T: AsRef<str>>(words: &[T]) -> String {
    let words: Vec<&str> = words.iter().map(AsRef::as_ref).collect();
    match words.as_slice() {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
    }
}

/// The word that `found` was probably meant to be.
pub(crate) fn nearest<'w>(found: &str, words: &[&'w str]) -> Option<&'w str> {
    words
        .iter()
        .map(|word| (distance(found, word), *word))
        .min()
        .filter(|(d, word)| *d <= 1 + word.chars().count() / 4)
        .map(|(_, word)| word)
}

/// Insertions, deletions, substitutions and swaps of neighbours between two words.
fn distance(a: &str, b: &str) -> usize {
    // Long strings are never misspelt keys, and the table grows with their product.
    let a: Vec<char> = a.chars().take(40).collect();
    let b: Vec<char> = b.chars().take(40).collect();
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for (i, row) in rows.iter_mut().enumerate() {
        row[0] = i;
    }
    for (j, cell) in rows[0].iter_mut().enumerate() {
        *cell = j;
    }
    for i in 1..=a.len() {
        for j in 1..=b.len() {
            let substitution = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = substitution.min(rows[i - 1][j] + 1).min(rows[i][j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(rows[i - 2][j - 2] + 1);
            }
            rows[i][j] = best;
        }
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misspellings_find_their_word_and_strangers_do_not() {
        let words = ["baud", "port", "birds", "hemisphere"];
        assert_eq!(nearest("buad", &words), Some("baud"));
        assert_eq!(nearest("hemishpere", &words), Some("hemisphere"));
        assert_eq!(nearest("colour", &words), None);
        assert_eq!(nearest("", &[]), None);
    }

    #[test]
    fn lists_read_as_a_sentence() {
        assert_eq!(or_list(&["a", "b", "c"]), "a, b or c");
        assert_eq!(or_list(&["a"]), "a");
    }
}

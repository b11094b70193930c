//! Values of parameters as a user writes them, and as the type of an FMU's variable takes them.

use std::convert::Infallible;
use std::fmt;
use std::str::FromStr;

use serde::Deserialize;

use crate::error::{unknown, Error};
use crate::fmu::Fmu;
use crate::variables::{Kind, Variable};

/// A number, a flag, or the name of an enumeration's item.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(
    untagged,
    expecting = "expected a number, true, false or the name of an item; the parameter's name \
                 stands in quotes: \"feedback.t_d\" = 0.1"
)]
pub enum Value {
    Number(f64),
    Flag(bool),
    Item(String),
}

impl Value {
    /// As FMI's functions take it: a flag is 0 or 1, an item its number. An error says what the
    /// variable takes instead.
    pub(crate) fn number_for(&self, variable: &Variable, fmu: &Fmu) -> Result<f64, Error> {
        let name = &variable.name;
        let items = fmu.items(variable);
        let must = |be: &str| Err(Error::new(format!("{name} = {self}, must be {be}")));
        match (variable.kind, self) {
            (Kind::String, _) => must("set in the FMU: the executor sets no String"),
            (Kind::Real, Value::Number(number)) if number.is_finite() => Ok(*number),
            (Kind::Real, _) => must("a finite number"),
            (Kind::Boolean, Value::Flag(flag)) => Ok(f64::from(u8::from(*flag))),
            (Kind::Boolean, Value::Number(number)) if [0.0, 1.0].contains(number) => Ok(*number),
            (Kind::Boolean, _) => must("0, 1, true or false"),
            (Kind::Integer, Value::Item(item)) if !items.is_empty() => {
                let entry = items.iter().find(|(known, _)| known == item);
                let names = || unknown("item", item, items.iter().map(|(known, _)| known.as_str()));
                entry.map(|(_, value)| *value).ok_or_else(|| Error::new(names()).at(name))
            }
            (Kind::Integer, Value::Number(number)) if items.is_empty() && whole(*number) => {
                Ok(*number)
            }
            (Kind::Integer, Value::Number(number)) if items.iter().any(|(_, v)| v == number) => {
                Ok(*number)
            }
            (Kind::Integer, _) if items.is_empty() => must("a whole number"),
            (Kind::Integer, _) => {
                let all: Vec<_> = items.iter().map(|(item, v)| format!("{v} {item}")).collect();
                must(&format!("one of {}", all.join(", ")))
            }
        }
    }
}

fn whole(number: f64) -> bool {
    number.fract() == 0.0 && number.abs() <= f64::from(i32::MAX)
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Number(number) => number.fmt(f),
            Value::Flag(flag) => flag.fmt(f),
            Value::Item(item) => item.fmt(f),
        }
    }
}

/// Of a command line, where nothing has quotes.
impl FromStr for Value {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Value, Infallible> {
        Ok(match (text.parse(), text.parse()) {
            (Ok(number), _) => Value::Number(number),
            (_, Ok(flag)) => Value::Flag(flag),
            _ => Value::Item(text.to_owned()),
        })
    }
}

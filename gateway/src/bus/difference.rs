//! What a drive holds, beside what the configuration expects.

use std::fmt;

/// One value of a drive that is not as expected.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    pub what: String,
    pub actual: String,
    pub expected: String,
    pub mend: String,
}

impl Difference {
    pub fn new(
        what: impl Into<String>,
        actual: impl ToString,
        expected: impl ToString,
        mend: impl Into<String>,
    ) -> Self {
        Difference {
            what: what.into(),
            actual: actual.to_string(),
            expected: expected.to_string(),
            mend: mend.into(),
        }
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} is {}, expected {}: {}", self.what, self.actual, self.expected, self.mend)
    }
}

//! Paths of variables: `$HOSTS_CFG[3].$SERVER_PORT`, `$MNUFRAME[1,8]`, `$UTOOL`.

use std::fmt;

/// One step of a [`SysPath`].
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// A name in upper case; of a system variable it includes the `$`.
    Name(String),
    /// Subscripts, one for each dimension; at least one.
    Index(Vec<i32>),
}

/// The path of a system variable, or of a variable of a program, as a host sees it.
///
/// It always starts with a name. `Display` writes it as a program would.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct SysPath {
    steps: Vec<Step>,
}

/// Why a path string is not a path.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{problem} at byte {offset} of the variable path")]
pub struct SysPathError {
    /// Byte offset into the string.
    pub offset: usize,
    /// What is wrong there.
    pub problem: &'static str,
}

/// No controller variable nests deeper.
const MAX_STEPS: usize = 32;

impl SysPath {
    /// A path of one name, such as `$UTOOL`; the name is put into upper case.
    #[must_use]
    pub fn from_name(name: &str) -> SysPath {
        SysPath {
            steps: vec![Step::Name(name.to_ascii_uppercase())],
        }
    }

    /// Appends a field's name, put into upper case.
    #[must_use]
    pub fn field(mut self, name: &str) -> SysPath {
        self.steps.push(Step::Name(name.to_ascii_uppercase()));
        self
    }

    /// Appends subscripts.
    #[must_use]
    pub fn index(mut self, subscripts: &[i32]) -> SysPath {
        self.steps.push(Step::Index(subscripts.to_vec()));
        self
    }

    /// Reads a path from a string, as `SET_VAR` and `GET_VAR` do at run time.
    ///
    /// Case does not matter and blanks around names and subscripts are skipped.
    ///
    /// # Errors
    /// A missing name or subscript, a subscript beyond 32 bits, or text after the path.
    pub fn parse(text: &str) -> Result<SysPath, SysPathError> {
        let mut cursor = Cursor {
            bytes: text.as_bytes(),
            offset: 0,
        };
        let mut steps = vec![Step::Name(cursor.expect_name()?)];
        loop {
            if steps.len() > MAX_STEPS {
                return Err(cursor.error("more than 32 steps"));
            }
            cursor.skip_blanks();
            match cursor.peek() {
                None => return Ok(SysPath { steps }),
                Some(b'.') => {
                    cursor.offset += 1;
                    steps.push(Step::Name(cursor.expect_name()?));
                }
                Some(b'[') => {
                    cursor.offset += 1;
                    steps.push(Step::Index(cursor.expect_subscripts()?));
                }
                Some(_) => return Err(cursor.error("unexpected character")),
            }
        }
    }

    /// The steps; the first is a name.
    #[must_use]
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// The first name, `$HOSTS_CFG` of `$HOSTS_CFG[3].$SERVER_PORT`.
    #[must_use]
    pub fn root(&self) -> &str {
        match self.steps.first() {
            Some(Step::Name(name)) => name,
            Some(Step::Index(_)) | None => "",
        }
    }

    /// Splits `$UTOOL.X` into `$UTOOL` and `X`: a last name without `$` is a component.
    pub(crate) fn split_component(&self) -> Option<(SysPath, &str)> {
        match self.steps.split_last() {
            Some((Step::Name(last), rest)) if !rest.is_empty() && !last.starts_with('$') => Some((
                SysPath {
                    steps: rest.to_vec(),
                },
                last,
            )),
            Some(_) | None => None,
        }
    }
}

impl fmt::Display for SysPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (position, step) in self.steps.iter().enumerate() {
            match step {
                Step::Name(name) if position == 0 => f.write_str(name)?,
                Step::Name(name) => write!(f, ".{name}")?,
                Step::Index(subscripts) => {
                    let list: Vec<String> = subscripts.iter().map(i32::to_string).collect();
                    write!(f, "[{}]", list.join(","))?;
                }
            }
        }
        Ok(())
    }
}

struct Cursor<'a> {
    bytes: &'a [u8],
    offset: usize,
}

impl Cursor<'_> {
    fn peek(&self) -> Option<u8> {
        self.bytes.get(self.offset).copied()
    }

    fn error(&self, problem: &'static str) -> SysPathError {
        SysPathError {
            offset: self.offset,
            problem,
        }
    }

    fn skip_blanks(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t')) {
            self.offset += 1;
        }
    }

    fn take_while(&mut self, accept: impl Fn(u8) -> bool) -> String {
        let mut taken = String::new();
        while let Some(byte) = self.peek().filter(|byte| accept(*byte)) {
            taken.push(char::from(byte));
            self.offset += 1;
        }
        taken
    }

    fn expect_name(&mut self) -> Result<String, SysPathError> {
        self.skip_blanks();
        let name =
            self.take_while(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'$'));
        if name.is_empty() {
            return Err(self.error("a name is missing"));
        }
        Ok(name.to_ascii_uppercase())
    }

    fn expect_subscripts(&mut self) -> Result<Vec<i32>, SysPathError> {
        let mut subscripts = Vec::new();
        loop {
            self.skip_blanks();
            let digits = self.take_while(|byte| byte.is_ascii_digit() || byte == b'-');
            let subscript = digits
                .parse()
                .map_err(|_| self.error("a subscript is missing"))?;
            subscripts.push(subscript);
            self.skip_blanks();
            let closing = self.peek();
            self.offset += 1;
            match closing {
                Some(b',') => {}
                Some(b']') => return Ok(subscripts),
                Some(_) | None => return Err(self.error("`,` or `]` is missing")),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_read_and_write_alike() {
        for text in [
            "$UTOOL",
            "$HOSTS_CFG[3].$SERVER_PORT",
            "$MNUFRAME[1,8]",
            "$MCR.$GENOVERRIDE",
        ] {
            assert_eq!(SysPath::parse(text).unwrap().to_string(), text);
        }
    }

    #[test]
    fn case_and_blanks_do_not_matter() {
        let path = SysPath::parse(" $mnuframe[ 1,  8 ] ").unwrap();
        assert_eq!(path.to_string(), "$MNUFRAME[1,8]");
    }

    #[test]
    fn a_missing_subscript_is_refused() {
        for text in [
            "$MNUFRAME[1,  ]",
            "$A[",
            "$A[1",
            "",
            "$A.",
            "$A]",
            "$A[99999999999]",
        ] {
            assert!(SysPath::parse(text).is_err(), "{text:?}");
        }
    }

    #[test]
    fn a_last_name_without_dollar_is_a_component() {
        let path = SysPath::parse("$MNUTOOL[1,2].x").unwrap();
        let (whole, component) = path.split_component().unwrap();
        assert_eq!(
            (whole.to_string().as_str(), component),
            ("$MNUTOOL[1,2]", "X")
        );
        assert_eq!(SysPath::parse("$MCR.$SPD").unwrap().split_component(), None);
    }
}

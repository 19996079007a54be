//! Tokens: their text, their secret, and the hash that is kept of it.

use std::fmt;

use api::TokenSecret;

/// Public, and in every log: which token it is.
#[derive(Clone, Debug, Eq, Hash, Ord, PartialEq, PartialOrd)]
pub(crate) struct TokenId(String);

/// 256 random bits. Never kept, never shown, except once to whoever made it.
#[derive(Clone)]
pub(crate) struct Secret([u8; SECRET_BYTES]);

/// What is kept of a secret. Comparing two takes the same time wherever they differ.
///
/// A fast hash is enough: the secret is random, so there is nothing to guess faster than by trying 2^256 of them.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) struct SecretHash(blake3::Hash);

const PREFIX: &str = "cell_";
const ID_BYTES: usize = 8;
const SECRET_BYTES: usize = 32;
/// So that the same secret has another hash in another program.
const CONTEXT: &str = "robocell 2026-11-22 bearer token secret v1";

/// The machine gives no random bytes; without them there are no secrets.
#[derive(Debug, thiserror::Error)]
#[error("asking the machine for random bytes")]
pub struct RandomError(#[source] getrandom::Error);

impl TokenId {
    pub(crate) fn as_str(&self) -> &str {
        &self.0
    }

    /// An id as it is written: 16 digits of base 16.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let _bytes: [u8; ID_BYTES] = unhex(text)?;
        Some(Self(text.to_owned()))
    }
}

impl fmt::Display for TokenId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl Secret {
    pub(crate) fn hash(&self) -> SecretHash {
        SecretHash(blake3::Hash::from(blake3::derive_key(CONTEXT, &self.0)))
    }
}

impl fmt::Debug for Secret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Secret(redacted)")
    }
}

impl SecretHash {
    /// A hash that no secret has, as far as anybody knows: for the comparison where there is no token to compare with.
    pub(crate) const NOBODYS: Self = Self(blake3::Hash::from_bytes([0; SECRET_BYTES]));

    pub(crate) fn to_hex(self) -> String {
        hex(self.0.as_bytes())
    }

    pub(crate) fn parse(text: &str) -> Option<Self> {
        unhex(text).map(|bytes| Self(blake3::Hash::from_bytes(bytes)))
    }
}

/// Makes a new token: its id, the hash to keep, and its text to show once.
pub(crate) fn generate() -> Result<(TokenId, SecretHash, TokenSecret), RandomError> {
    let mut id = [0; ID_BYTES];
    let mut secret = [0; SECRET_BYTES];
    getrandom::fill(&mut id).map_err(RandomError)?;
    getrandom::fill(&mut secret).map_err(RandomError)?;
    let id = TokenId(hex(&id));
    let text = TokenSecret::new(format!("{PREFIX}{id}_{}", hex(&secret)));
    Ok((id, Secret(secret).hash(), text))
}

/// Takes a token's text apart.
pub(crate) fn parse(text: &str) -> Option<(TokenId, Secret)> {
    let (id, secret) = text.strip_prefix(PREFIX)?.split_once('_')?;
    Some((TokenId::parse(id)?, Secret(unhex(secret)?)))
}

fn hex(bytes: &[u8]) -> String {
    use fmt::Write as _;
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// Lower-case digits of base 16 only, so that each value has one text.
fn unhex<const N: usize>(text: &str) -> Option<[u8; N]> {
    let digit = |byte: u8| match byte {
        b'0'..=b'9' => Some(byte - b'0'),
        b'a'..=b'f' => Some(byte - b'a' + 10),
        _ => None,
    };
    let (pairs, rest) = text.as_bytes().as_chunks::<2>();
    if pairs.len() != N || !rest.is_empty() {
        return None;
    }
    let mut bytes = [0; N];
    for (byte, [high, low]) in bytes.iter_mut().zip(pairs) {
        *byte = digit(*high)? << 4 | digit(*low)?;
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_read_as_it_was_made_and_only_its_own_secret_fits() {
        let (id, hash, text) = generate().unwrap();
        let (read, secret) = parse(text.reveal()).unwrap();
        assert_eq!((read, secret.hash()), (id, hash));
        let (_, other, _) = generate().unwrap();
        assert_ne!(hash, other);
        assert_eq!(SecretHash::parse(&hash.to_hex()), Some(hash));
        assert!(!format!("{secret:?}{text:?}").contains(&text.reveal()[22..]));
    }

    #[test]
    fn what_is_no_token_is_refused() {
        let (_, _, text) = generate().unwrap();
        let text = text.reveal();
        let upper = text.to_uppercase();
        let long = format!("{text}0");
        for bad in [
            "",
            "cell_",
            "cell__",
            "cell_1_2",
            &text[1..],
            &text[..80],
            &upper,
            &long,
        ] {
            assert!(parse(bad).is_none(), "{bad}");
        }
        assert!(parse(&text.replace('_', "-")).is_none());
        assert!(parse(&format!("{}é0", &text[..83])).is_none());
    }
}

use protocol::v2::{DecodeError, LineDecoder};
use tokio::io::{AsyncRead, AsyncReadExt as _};

use super::error::ReadError;

/// How much is read at once.
const CHUNK: usize = 1024;
/// How much of a line that is not understood is kept for the record.
const KEPT: usize = 120;

/// A connection, read line by line.
#[derive(Debug)]
pub(super) struct LineStream<S> {
    pub(super) stream: S,
    decoder: LineDecoder,
    received: Vec<u8>,
    taken: usize,
}

impl<S: AsyncRead + Unpin> LineStream<S> {
    pub(super) fn new(stream: S) -> Self {
        Self {
            stream,
            decoder: LineDecoder::default(),
            received: Vec::with_capacity(CHUNK),
            taken: 0,
        }
    }

    /// The next line, decoded. Dropping the future loses nothing.
    pub(super) async fn next<T>(
        &mut self,
        decode: impl Fn(&[u8]) -> Result<T, DecodeError>,
    ) -> Result<T, ReadError> {
        loop {
            while let Some(byte) = self.received.get(self.taken) {
                self.taken += 1;
                match self.decoder.push(*byte) {
                    Ok(None) => {}
                    Ok(Some(line)) => {
                        return decode(line).map_err(|source| ReadError::Line {
                            text: kept(line),
                            source,
                        });
                    }
                    Err(_too_long) => return Err(ReadError::TooLong),
                }
            }
            self.received.clear();
            self.taken = 0;
            match self.stream.read_buf(&mut self.received).await {
                Ok(0) => return Err(ReadError::Closed),
                Ok(_) => {}
                Err(source) => return Err(ReadError::Io(source)),
            }
        }
    }
}

/// The beginning of a line, without anything that could forge a line of the log.
fn kept(line: &[u8]) -> String {
    line.get(..KEPT).unwrap_or(line).escape_ascii().to_string()
}

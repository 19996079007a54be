//! Messages of `simple_message`, written from a description of the wire.

use anyhow::{Result, bail};

pub(crate) const JOINT_POSITION: i32 = 10;
pub(crate) const JOINT_TRAJ_PT: i32 = 11;
pub(crate) const STATUS: i32 = 13;
pub(crate) const REPLY_SUCCESS: i32 = 1;
pub(crate) const REPLY_FAILURE: i32 = 2;

/// A message of `simple_message`: big endian, 4 bytes a field.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Message {
    pub(crate) kind: i32,
    pub(crate) communication: i32,
    pub(crate) reply: i32,
    /// The fields behind the header.
    pub(crate) body: Vec<[u8; 4]>,
}

impl Message {
    pub(crate) fn point(sequence: i32, joints_deg: [f32; 6]) -> Self {
        let joints = joints_deg.iter().map(|deg| deg.to_radians());
        let joints = joints.chain([0.0; 4]).map(f32::to_be_bytes);
        let velocity_and_duration = [0.1_f32.to_be_bytes(), 1.0_f32.to_be_bytes()];
        Self {
            kind: JOINT_TRAJ_PT,
            communication: 2,
            reply: 0,
            body: [sequence.to_be_bytes()]
                .into_iter()
                .chain(joints)
                .chain(velocity_and_duration)
                .collect(),
        }
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        let length = 12 + 4 * i32::try_from(self.body.len()).unwrap_or(i32::MAX);
        let header = [length, self.kind, self.communication, self.reply].map(i32::to_be_bytes);
        header.iter().chain(&self.body).flatten().copied().collect()
    }

    /// Takes one message off the front, if there is a whole one.
    pub(crate) fn take(bytes: &mut Vec<u8>) -> Result<Option<Self>> {
        let Some(length) = bytes.first_chunk::<4>() else {
            return Ok(None);
        };
        let length = i32::from_be_bytes(*length);
        let length = usize::try_from(length)
            .ok()
            .filter(|l| (12..=64).contains(l));
        let Some(length) = length.filter(|length| length % 4 == 0) else {
            bail!("a message of {length:?} bytes: the stream has gaps");
        };
        if bytes.len() < length + 4 {
            return Ok(None);
        }
        let message: Vec<u8> = bytes.drain(..length + 4).collect();
        let fields: Vec<[u8; 4]> = message
            .chunks_exact(4)
            .filter_map(|chunk| chunk.first_chunk::<4>().copied())
            .collect();
        let header = |at: usize| fields.get(at).copied().map_or(-1, i32::from_be_bytes);
        Ok(Some(Self {
            kind: header(1),
            communication: header(2),
            reply: header(3),
            body: fields.get(4..).unwrap_or_default().to_vec(),
        }))
    }

    pub(crate) fn integer(&self, at: usize) -> i32 {
        self.body.get(at).copied().map_or(-1, i32::from_be_bytes)
    }

    pub(crate) fn reals(&self) -> Vec<f32> {
        let fields = self.body.iter().skip(1);
        fields.map(|field| f32::from_be_bytes(*field)).collect()
    }

    /// Type, communication, reply and sequence number.
    pub(crate) fn head(&self) -> String {
        let Self {
            kind,
            communication,
            reply,
            ..
        } = self;
        format!(
            "type {kind}, comm {communication}, reply {reply}, seq {}",
            self.integer(0)
        )
    }
}

/// So many bytes in groups of four, as tools of the network show them.
pub(crate) fn hex(bytes: &[u8], count: usize) -> String {
    let fields = bytes.get(..count).unwrap_or(bytes).chunks(4);
    let fields: Vec<String> = fields
        .filter_map(|field| field.first_chunk::<4>())
        .map(|field| format!("{:08x}", u32::from_be_bytes(*field)))
        .collect();
    fields.join(" ")
}

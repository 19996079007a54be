//! Inputs to begin with: the golden programs, the shipped ones, recorded bytes.

use std::path::{Path, PathBuf};
use std::{fs, io};

use crate::Target;

/// Writes the seeds and the dictionary of a target into a folder of its own; libFuzzer's flags for them.
///
/// # Errors
/// A file cannot be written.
pub fn write(target: Target, folder: &Path) -> io::Result<Vec<String>> {
    let folder = folder.join(target.name);
    fs::create_dir_all(&folder)?;
    for (number, seed) in (target.seeds)().iter().enumerate() {
        let seed = seed.get(..target.longest).unwrap_or(seed);
        fs::write(folder.join(format!("seed-{number:03}")), seed)?;
    }
    let mut flags = vec![
        folder.display().to_string(),
        format!("-max_len={}", target.longest),
    ];
    if !target.words.is_empty() {
        let dictionary = folder.with_extension("dict");
        let lines: Vec<String> = target.words.iter().map(|word| quoted(word)).collect();
        fs::write(&dictionary, lines.join("\n") + "\n")?;
        flags.push(format!("-dict={}", dictionary.display()));
    }
    Ok(flags)
}

/// A word as a dictionary of libFuzzer has it.
fn quoted(word: &str) -> String {
    let escaped: String = word
        .bytes()
        .map(|byte| match byte {
            b'"' | b'\\' => format!("\\{}", char::from(byte)),
            b' '..=b'~' => char::from(byte).to_string(),
            other => format!("\\x{other:02X}"),
        })
        .collect();
    format!("\"{escaped}\"")
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The files of a folder with this extension, in the order of their names.
fn files_of(folder: &str, extension: &str) -> Vec<Vec<u8>> {
    let Ok(entries) = fs::read_dir(root().join(folder)) else {
        return Vec::new();
    };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|end| end == extension));
    paths.sort();
    paths
        .iter()
        .filter_map(|path| fs::read(path).ok())
        .collect()
}

/// KAREL sources.
#[must_use]
pub fn karel() -> Vec<Vec<u8>> {
    let folders = [
        "crates/karel/tests/cases",
        "crates/karel/tests/cases/more",
        "programs",
        "programs/include",
        "karel-emulator/tests/programs",
    ];
    folders
        .iter()
        .flat_map(|folder| files_of(folder, "kl"))
        .collect()
}

/// Listings of TP programs.
#[must_use]
pub fn listings() -> Vec<Vec<u8>> {
    let mut found = files_of("programs", "ls");
    found.extend(files_of("crates/karel/tests/cases/more", "ls"));
    found.push(LISTING.as_bytes().to_vec());
    found
}

/// One line of each kind.
const LISTING: &str = "/PROG  ALL
/ATTR
OWNER = X;
/MN
   1:  !remark ;
   2:  R[1:n]=R[2]+1 ;
   3:  IF (R[1]>5 AND DI[1]=ON),JMP LBL[1] ;
   4:  SELECT R[1]=1,CALL OTHER(1,'x',R[2]) ;
   5:         =2,JMP LBL[1] ;
   6:         ELSE,JMP LBL[2] ;
   7:  LBL[1:a] ;
   8:  FOR R[1]=1 TO 3 ;
   9:  J P[1] 50% FINE    ;
  10:  L PR[2] R[3]mm/sec CNT50 ACC80 Offset,PR[3]    ;
  11:  C P[1] ;
    :  P[2] 100mm/sec FINE    ;
  12:  ENDFOR ;
  13:  IF (R[1]=1) THEN ;
  14:  DO[1]=ON ;
  15:  ELSE ;
  16:  RO[1]=PULSE,0.5sec ;
  17:  ENDIF ;
  18:  WAIT DI[1]=ON TIMEOUT,LBL[2] ;
  19:  WAIT .50(sec) ;
  20:  PR[1,2]=R[1]*(-2.5) ;
  21:  SR[1]=SR[2]+'text' ;
  22:  UFRAME_NUM=1 ;
  23:  UTOOL[1]=PR[2] ;
  24:  OVERRIDE=50% ;
  25:  MESSAGE[hello] ;
  26:  SKIP CONDITION DI[2]=ON ;
  27:  L P[1] 50mm/sec FINE Skip,LBL[2]    ;
  28:  $WAITTMOUT=100 ;
  29:  RUN OTHER ;
  30:  LBL[2] ;
  31:  END ;
/POS
P[1]{
   GP1:
\tUF : 0, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',
\tX =   985.0  mm,\tY =     0.0  mm,\tZ =   940.0  mm,
\tW =  -180.0 deg,\tP =     0.0 deg,\tR =     0.0 deg
};
P[2]{
   GP1:
\tUF : 0, UT : 1,
\tJ1=     0.0 deg,\tJ2=     0.0 deg,\tJ3=     0.0 deg,
\tJ4=     0.0 deg,\tJ5=   -90.0 deg,\tJ6=     0.0 deg
};
/END
";

/// Decisions: any bytes are some.
#[must_use]
pub fn choices() -> Vec<Vec<u8>> {
    (0..64_u32).map(|seed| noise(seed, 200)).collect()
}

/// Decisions about what is read, and bytes to read.
#[must_use]
pub fn readings() -> Vec<Vec<u8>> {
    let texts: [&[u8]; 5] = [
        b"600000 200000 600000 -180000 30000 0 300 1",
        b"12 abc,-3.5E2\r\nTRUE 'x'\n\n  7\r\r\n",
        b"\x00\x00\x00\x2a\x3f\x80\x00\x00\xff\xff\xff\xff\x7f\xc0\x00\x00",
        b"a b c d e f g h\n1.\n.5\n+1\n-\n1e\n",
        &[b'9'; 300],
    ];
    let mut found = Vec::new();
    for seed in 0..12 {
        for text in texts {
            let mut input = noise(seed, 24);
            input.extend_from_slice(text);
            found.push(input);
        }
    }
    found
}

/// Decisions of peers.
#[must_use]
pub fn peers() -> Vec<Vec<u8>> {
    (100..164_u32).map(|seed| noise(seed, 120)).collect()
}

/// Requests to the control interface.
#[must_use]
pub fn requests() -> Vec<Vec<u8>> {
    let bodies: [&[u8]; 8] = [
        br#"{"path": "[WORK]I", "value": 5}"#,
        br#"{"fault": {"delay": {"ms": 200}}, "scope": {"port": 59002, "direction": "in"}, "times": 3}"#,
        br#"{"value": true}"#,
        br#"{"override_percent": 50, "mode": "T1"}"#,
        br#"{"facility": "SRVO", "number": 50, "text": "x", "severity": "pause"}"#,
        br#"{"j1_deg": 0, "j2_deg": 0, "j3_deg": 0, "j4_deg": 0, "j5_deg": -90, "j6_deg": 0}"#,
        br#"{"ms": 100}"#,
        br#"{"x_mm": 1, "y_mm": 2, "z_mm": 3, "w_deg": 0, "p_deg": 0, "r_deg": 0}"#,
    ];
    let mut found = Vec::new();
    for (number, body) in bodies.iter().enumerate() {
        for path in 0..39_u8 {
            let method = u8::try_from(number).unwrap_or_default();
            let length = u16::try_from(body.len()).unwrap_or_default().to_be_bytes();
            let mut input = vec![method % 5, path, 0];
            input.extend_from_slice(&length);
            input.extend_from_slice(body);
            input.push(50);
            found.push(input);
        }
    }
    found
}

/// Arm models.
#[must_use]
pub fn files() -> Vec<Vec<u8>> {
    files_of("crates/kinematics/models", "toml")
}

/// Recorded bytes of both protocols.
#[must_use]
pub fn wire() -> Vec<Vec<u8>> {
    let mut found = Vec::new();
    for folder in ["crates/protocol/testdata/v1", "crates/protocol/testdata/v2"] {
        for text in files_of(folder, "hex") {
            let text = String::from_utf8_lossy(&text).into_owned();
            let lines = text.lines().filter(|line| !line.starts_with('#'));
            let digits: String = lines.collect::<String>().split_whitespace().collect();
            let pairs = digits.as_bytes().chunks(2);
            found.push(
                pairs
                    .filter_map(|pair| std::str::from_utf8(pair).ok())
                    .filter_map(|pair| u8::from_str_radix(pair, 16).ok())
                    .collect(),
            );
        }
    }
    found
}

/// Bytes of a small generator, the same ones each time.
fn noise(seed: u32, length: usize) -> Vec<u8> {
    let mut state = seed.wrapping_mul(2_654_435_761).max(1);
    (0..length)
        .map(|_| {
            state ^= state << 13;
            state ^= state >> 17;
            state ^= state << 5;
            (state >> 11).to_le_bytes()[0]
        })
        .collect()
}

//! Frames of a run on disk: what its pictures are made of, so that they can be made again without running again.
//!
//! One file: a line of JSON that says what follows, then numbers of four bytes. CSV would take three times the room
//! and most of the time to read; pictures need no more than the seven digits of four bytes. Times stay exact: they
//! stand in the line of JSON.

#[cfg(test)]
pub mod made_up;
mod record;

use std::fs::File;
use std::io::{self, BufRead, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use mpm_core::observe::{CellState, Frame, SolidState, WaterParticle};
use mpm_core::scene::Scene;
use mpm_core::step::Model;
use serde::{Deserialize, Serialize};

use record::{Record, layer};

/// A frame with what a reader must know of it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Shot {
    /// Phase of the run, in words: `seepage`, `failure`.
    pub phase: String,
    /// Time on the reader's clock, s: a run may begin hours after what it follows.
    pub time_s: f64,
    /// Both layers and the cells.
    pub frame: Frame,
}

impl Shot {
    /// Time on the reader's clock, h.
    pub fn hours(&self) -> f64 {
        self.time_s / 3600.0
    }
}

/// Frames of a scene that is solved stage by stage: the start, and each observed time.
#[derive(Debug, Clone, Default)]
pub struct Recorded {
    /// The frames.
    pub shots: Vec<Shot>,
    cells: [usize; 2],
    size: f64,
}

impl Recorded {
    /// None yet.
    pub fn of(scene: &Scene) -> Self {
        Self { shots: Vec::new(), cells: scene.cells, size: scene.cell }
    }

    /// Takes a frame of the particles at a time, s since the start. Displacements that the run does not count are those from the first frame.
    pub fn take(&mut self, model: &dyn Model, time_s: f64) {
        let (mut solid, water) = (model.particles(), model.water_particles());
        solid.sort_by_key(|p| p.id);
        let first = self.shots.first().map_or_else(|| solid.clone(), |shot| shot.frame.solid.clone());
        for (now, then) in
            solid.iter_mut().zip(&first).filter(|(now, then)| now.displacement[0].is_nan() && now.id == then.id)
        {
            now.displacement = [0, 1].map(|axis| now.x[axis] - then.x[axis]);
        }
        let frame = Frame { time_s, step: 0, cells: self.cells, size: self.size, solid, water, cell: Vec::new() };
        self.shots.push(Shot { phase: String::new(), time_s, frame });
    }
}

/// Mean effective stress of a particle, Pa, compression positive.
pub fn mean_stress(soil: &SolidState) -> f64 {
    let [xx, yy, zz, _] = soil.stress;
    -(xx + yy + zz) / 3.0
}

/// Why frames could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum FramesError {
    /// The file cannot be written.
    #[error("{}: cannot be written: {cause}", path.display())]
    Write {
        /// Which.
        path: PathBuf,
        /// Why not.
        #[source]
        cause: io::Error,
    },
    /// The file cannot be read.
    #[error("{}: cannot be read: {cause}", path.display())]
    Read {
        /// Which.
        path: PathBuf,
        /// Why not.
        #[source]
        cause: io::Error,
    },
}

/// What the file holds; its first line.
#[derive(Debug, Serialize, Deserialize)]
struct Header {
    /// Always [`FORMAT`].
    format: String,
    /// Numbers of a solid particle, a water particle and a cell, in their order, with units.
    columns: [Vec<String>; 3],
    frames: Vec<Entry>,
}

/// A frame in the header.
#[derive(Debug, Serialize, Deserialize)]
struct Entry {
    phase: String,
    time_s: f64,
    run_s: f64,
    step: u64,
    cells: [usize; 2],
    size_m: f64,
    /// Solid particles, water particles, cells.
    counts: [usize; 3],
}

/// Name and version of the format.
const FORMAT: &str = "frames of two layers, 1";

/// Writes frames into one file.
///
/// # Errors
/// A file that cannot be written, with its path.
pub fn write(shots: &[Shot], path: &Path) -> Result<(), FramesError> {
    let written = || {
        let mut file = BufWriter::new(File::create(path)?);
        write_to(shots, &mut file)?;
        file.flush()
    };
    written().map_err(|cause| FramesError::Write { path: path.to_owned(), cause })
}

/// Reads them back: times to the last bit, all else to seven digits.
///
/// # Errors
/// A file that cannot be read, is of another format, or is too short or too long.
pub fn read(path: &Path) -> Result<Vec<Shot>, FramesError> {
    let taken = || read_from(&mut BufReader::new(File::open(path)?));
    taken().map_err(|cause| FramesError::Read { path: path.to_owned(), cause })
}

/// Writes frames to where bytes go.
///
/// # Errors
/// What the place says.
pub fn write_to(shots: &[Shot], file: &mut impl Write) -> io::Result<()> {
    serde_json::to_writer(&mut *file, &header(shots))?;
    file.write_all(b"\n")?;
    for Shot { frame, .. } in shots {
        put(&frame.solid, file)?;
        put(&frame.water, file)?;
        put(&frame.cell, file)?;
    }
    Ok(())
}

/// Reads frames from where bytes come from.
///
/// # Errors
/// Bytes of another format, too few or too many.
pub fn read_from(file: &mut impl BufRead) -> io::Result<Vec<Shot>> {
    let mut line = Vec::new();
    file.read_until(b'\n', &mut line)?;
    let header: Header = serde_json::from_slice(&line)?;
    expect(FORMAT, &header.format)?;
    expect([names::<SolidState>(), names::<WaterParticle>(), names::<CellState>()], &header.columns)?;
    let shots = header.frames.into_iter().map(|entry| shot(entry, file)).collect::<io::Result<_>>()?;
    let over = file.bytes().count();
    if over > 0 { Err(odd(format!("expected its end, found {over} more bytes"))) } else { Ok(shots) }
}

/// A frame as a file gives it back: pictures of a run and those made again from its file are the same.
pub fn rounded(frame: &Frame) -> Frame {
    Frame {
        solid: frame.solid.iter().map(|p| Record::from_words(&p.words())).collect(),
        water: frame.water.iter().map(|p| Record::from_words(&p.words())).collect(),
        cell: frame.cell.iter().map(|c| Record::from_words(&c.words())).collect(),
        ..frame.clone()
    }
}

fn header(shots: &[Shot]) -> Header {
    let entry = |shot: &Shot| Entry {
        phase: shot.phase.clone(),
        time_s: shot.time_s,
        run_s: shot.frame.time_s,
        step: shot.frame.step,
        cells: shot.frame.cells,
        size_m: shot.frame.size,
        counts: [shot.frame.solid.len(), shot.frame.water.len(), shot.frame.cell.len()],
    };
    Header {
        format: FORMAT.to_owned(),
        columns: [names::<SolidState>(), names::<WaterParticle>(), names::<CellState>()],
        frames: shots.iter().map(entry).collect(),
    }
}

fn names<R: Record>() -> Vec<String> {
    R::NAMES.iter().map(|name| (*name).to_owned()).collect()
}

fn put<R: Record>(all: &[R], file: &mut impl Write) -> io::Result<()> {
    all.iter().try_for_each(|one| one.words().iter().try_for_each(|word| file.write_all(&word.to_le_bytes())))
}

fn shot(entry: Entry, file: &mut impl Read) -> io::Result<Shot> {
    let frame = Frame {
        time_s: entry.run_s,
        step: entry.step,
        cells: entry.cells,
        size: entry.size_m,
        solid: layer(entry.counts[0], file)?,
        water: layer(entry.counts[1], file)?,
        cell: layer(entry.counts[2], file)?,
    };
    Ok(Shot { phase: entry.phase, time_s: entry.time_s, frame })
}

/// Refuses what is not as expected.
fn expect<T: PartialEq<U> + std::fmt::Debug, U: std::fmt::Debug>(expected: T, found: &U) -> io::Result<()> {
    if expected == *found { Ok(()) } else { Err(odd(format!("expected {expected:?}, found {found:?}"))) }
}

fn odd(words: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, words)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What four bytes keep of a number.
    fn kept(value: f64) -> f64 {
        f64::from(value as f32)
    }

    #[test]
    fn frames_come_back_to_seven_digits_and_times_to_the_last_bit() {
        let shots = made_up::shots(3, 2);
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("frames.bin");
        write(&shots, &path).expect("written");
        let back = read(&path).expect("read");
        assert_eq!(back.len(), shots.len());
        for (a, b) in shots.iter().zip(&back) {
            assert_eq!(
                (&a.phase, a.time_s, a.frame.time_s, a.frame.step),
                (&b.phase, b.time_s, b.frame.time_s, b.frame.step)
            );
            assert_eq!((a.frame.cells, a.frame.size), (b.frame.cells, b.frame.size));
            assert_eq!(a.frame.water.len(), b.frame.water.len());
            for (p, q) in a.frame.solid.iter().zip(&b.frame.solid) {
                assert_eq!((p.id, p.x.map(kept), p.stress.map(kept)), (q.id, q.x, q.stress));
                assert_eq!((kept(p.deviator_strain), kept(p.mass)), (q.deviator_strain, q.mass));
            }
            let pressures = a.frame.water.iter().zip(&b.frame.water).map(|(p, q)| (kept(p.pressure), q.pressure));
            assert!(pressures.into_iter().all(|(p, q)| p == q));
            assert!(a.frame.cell.iter().zip(&b.frame.cell).all(|(p, q)| kept(p.soil) == q.soil));
        }
        // Written again, the bytes are the same: nothing more is lost.
        let again = folder.path().join("again.bin");
        write(&back, &again).expect("written");
        assert_eq!(std::fs::read(&path).expect("bytes"), std::fs::read(&again).expect("bytes"));
    }

    #[test]
    fn what_is_cut_off_too_long_or_something_else_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("frames.bin");
        write(&made_up::shots(1, 0), &path).expect("written");
        let bytes = std::fs::read(&path).expect("bytes");
        let refused = |bytes: &[u8]| {
            std::fs::write(&path, bytes).expect("written");
            read(&path).expect_err("refused").to_string()
        };
        assert!(refused(&bytes[..bytes.len() - 1]).contains("fill whole buffer"));
        assert!(refused(&[&bytes[..], &[0]].concat()).contains("found 1 more bytes"));
        let other = String::from_utf8_lossy(&bytes).replacen(FORMAT, "frames of two layers, 9", 1);
        assert!(refused(other.as_bytes()).contains("two layers, 9"));
        assert!(read(&folder.path().join("none")).is_err());
    }
}

//! A frame file being written.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::layout::{self, Filled, Layout};
use super::read::{self, Index};
use super::shape::Shape;
use super::{Frame, Meaning, PART_BYTES, part};
use crate::column::assert_name;
use crate::error::Error;
use crate::h5;
use crate::system::{Alone, Aside, clear, dotted, folder, refused, sync, write_aside};

/// VTKHDF files that grow by frames; nothing of them is kept open or in memory between calls.
#[derive(Debug)]
pub struct FrameFile {
    path: PathBuf,
    scratch: PathBuf,
    attributes: Vec<(String, String)>,
    meanings: &'static [Meaning],
    part_bytes: u64,
    /// The most rows that frames are known to have.
    rows: usize,
    /// Parts that are closed, and frames in them.
    closed: usize,
    frames_closed: usize,
    /// The part that grows: how it is laid out, and what it holds.
    layout: Layout,
    filled: Filled,
    /// Whether it has the layout of this version, to which frames can be added.
    is_of_now: bool,
    /// A second file of the same, for the next frame. It is never taken up from an earlier process.
    twin: Option<Twin>,
}

/// The file that had the name of a part before the one that has it now, and what it holds: all frames but the last.
#[derive(Debug)]
struct Twin {
    file: Aside,
    filled: Filled,
}

impl FrameFile {
    /// Creates the file with `first` in it; all later frames must have the same fields. A file already there is refused.
    ///
    /// Everything in the making lies in the folder `scratch`, on the file system of `path`; what an earlier process left
    /// there of this file is removed. `rows_hint` is how many rows frames will have at most, as far as is known: that many
    /// are stored as one. `attributes` tell who writes the file ([`attributes`](super::attributes)), `meanings` what its fields are.
    ///
    /// Panics, as [`append`](FrameFile::append) does, if a field is neither `f64` nor `i64` or lacks a row per point; and
    /// if the text of an attribute has more than 1024 bytes or has a zero among them.
    pub fn create(
        path: &Path,
        scratch: &Path,
        first: &Frame,
        rows_hint: usize,
        attributes: &[(&str, &str)],
        meanings: &'static [Meaning],
    ) -> Result<FrameFile, Error> {
        for (key, text) in attributes {
            assert_name(key);
            assert!(text.len() <= h5::TEXT_BYTES_MAX && !text.contains('\0'), "frames: attribute {key} cannot be one");
        }
        for path in [path.to_owned(), part(path, 1)] {
            if fs::exists(&path).unwrap_or(true) {
                let source = std::io::ErrorKind::AlreadyExists.into();
                return Err(Error::System { action: "create", path, source });
            }
        }
        clear(scratch, &dotted(path.file_stem()), Duration::ZERO);
        let mut file = FrameFile {
            path: path.to_owned(),
            scratch: scratch.to_owned(),
            attributes: attributes.iter().map(|(key, text)| ((*key).to_owned(), (*text).to_owned())).collect(),
            meanings,
            part_bytes: PART_BYTES,
            rows: rows_hint,
            closed: 0,
            frames_closed: 0,
            layout: Layout::new(Shape::of(first), rows_hint),
            filled: Filled::default(),
            is_of_now: true,
            twin: None,
        };
        file.begin_part(first)?;
        Ok(file)
    }

    /// Takes the file up again with its first `steps` frames; the rest are cut off. `scratch` and `meanings`, of parts that are still to come, are
    /// as for [`create`](FrameFile::create).
    ///
    /// [`Error::TooFewFrames`] if it has fewer; with [`Error::is_damage`] if it is not whole. A part that an earlier version
    /// of this program laid out is closed: the next frame goes to another.
    pub fn open_and_cut(
        path: &Path,
        scratch: &Path,
        steps: usize,
        meanings: &'static [Meaning],
    ) -> Result<FrameFile, Error> {
        let (mut closed, mut frames_closed) = (0, 0);
        let mut index = Index::open(path)?;
        while frames_closed + index.frames() < steps {
            let found = frames_closed + index.frames();
            let next = part(path, closed + 1);
            if !next.exists() {
                return Err(Error::TooFewFrames { path: path.to_owned(), found, expected: steps });
            }
            (closed, frames_closed, index) = (closed + 1, found, Index::open(&next)?);
        }
        clear(scratch, &dotted(path.file_stem()), Duration::ZERO);
        // The last goes first: what is left at any moment are the frames that were written first.
        let beyond = (closed + 1..).map(|number| part(path, number)).take_while(|part| part.exists());
        let beyond: Vec<PathBuf> = beyond.collect();
        for part in beyond.iter().rev() {
            fs::remove_file(part).map_err(refused("remove", part))?;
            sync(folder(part))?;
        }
        let rows = index.rows.iter().copied().max().unwrap_or(0);
        let layout = index.layout();
        let is_of_now = layout.is_some();
        let layout = layout.unwrap_or_else(|| Layout::new(index.shape.clone(), rows));
        let filled = index.filled(&layout, steps - frames_closed);
        let file = FrameFile {
            path: path.to_owned(),
            scratch: scratch.to_owned(),
            attributes: read::attributes(path)?.into_iter().collect(),
            meanings,
            part_bytes: PART_BYTES,
            rows: rows.max(layout.chunk_rows),
            closed,
            frames_closed,
            layout,
            filled,
            is_of_now,
            twin: None,
        };
        if index.frames() > filled.frames {
            // A reader that holds the file open keeps what it had: it is another that takes the name.
            let cut = Aside::within(scratch, &file.growing())?;
            fs::copy(file.growing(), cut.partial()).map_err(refused("copy", &file.growing()))?;
            file.cut(cut.partial(), &index)?;
            cut.name()?;
        }
        Ok(file)
    }

    /// Closes parts at other sizes than [`PART_BYTES`].
    pub fn with_parts_of(self, part_bytes: u64) -> FrameFile {
        FrameFile { part_bytes, ..self }
    }

    /// Whether its frames have a field of that name.
    pub fn has(&self, field: &str) -> bool {
        self.layout.shape.fields.iter().any(|has| has.name == field)
    }

    /// Adds a frame and returns once it is safely on disk.
    ///
    /// [`Error::FrameFields`] if the fields are not, in this order, those of the first frame. After any error the files
    /// are as they were, and the append may be tried again.
    pub fn append(&mut self, frame: &Frame) -> Result<(), Error> {
        let shape = Shape::of(frame);
        if shape != self.layout.shape {
            let (found, expected) = (shape.to_string(), self.layout.shape.to_string());
            return Err(Error::FrameFields { path: self.path.clone(), found, expected });
        }
        let path = self.growing();
        let bytes = fs::metadata(&path).map_err(refused("look at", &path))?.len();
        if self.filled.frames == 0 || !self.is_of_now || bytes >= self.part_bytes {
            return self.begin_part(frame);
        }
        // One that cannot be written to may itself be at fault.
        let file = match self.add_to_twin(&path, frame).ok().flatten() {
            Some(file) => file,
            None => self.add_to_copy(&path, frame)?,
        };
        let before = file.exchange()?;
        // Without one the next frame goes into a copy.
        self.twin = before.map(|file| Twin { file, filled: self.filled });
        self.filled = self.layout.and(self.filled, frame.rows());
        Ok(())
    }

    /// The second file with all frames and this one; none if there is no such file, or somebody else has it.
    ///
    /// It is looked at no sooner than now: by now whoever opened it while it had the name has come to lock it.
    fn add_to_twin(&mut self, path: &Path, frame: &Frame) -> Result<Option<Aside>, Error> {
        let Some(Twin { file, filled }) = self.twin.take() else { return Ok(None) };
        let Some(_alone) = Alone::with(file.partial())? else { return Ok(None) };
        let whole = h5::open(path, false)?;
        change(file.partial(), "write", |twin| {
            self.layout.follow(twin, &whole, filled)?;
            self.layout.append(twin, self.filled, frame)
        })?;
        Ok(Some(file))
    }

    /// A copy of the part that grows with this frame.
    fn add_to_copy(&self, path: &Path, frame: &Frame) -> Result<Aside, Error> {
        let file = Aside::within(&self.scratch, path)?;
        fs::copy(path, file.partial()).map_err(refused("copy", path))?;
        // A frame may have got there though its append failed: at the very last, when the folder was to be written to disk.
        let index = Index::open(file.partial())?;
        if index.frames() > self.filled.frames {
            self.cut(file.partial(), &index)?;
        }
        change(file.partial(), "write", |file| self.layout.append(file, self.filled, frame))?;
        Ok(file)
    }

    fn cut(&self, path: &Path, index: &Index) -> Result<(), Error> {
        change(path, "cut", |file| match self.is_of_now {
            true => self.layout.cut(file, self.filled),
            false => layout::cut(file, index.shape.drawn, self.filled.frames, index.start(self.filled.frames)),
        })
    }

    /// Goes on in another part, or makes the one anew that has no frame.
    fn begin_part(&mut self, frame: &Frame) -> Result<(), Error> {
        let goes_on = self.filled.frames > 0;
        let number = self.closed + usize::from(goes_on);
        let rows = self.rows.max(frame.rows());
        let layout = Layout::new(self.layout.shape.clone(), rows);
        let aside = Aside::within(&self.scratch, &part(&self.path, number))?;
        write_aside(aside, |partial| {
            let file = h5::create(partial)?;
            let mut attributes = self.attributes.iter();
            attributes
                .try_for_each(|(key, text)| h5::write_text(&file, key, text))
                .and_then(|()| layout.create(&file, self.meanings))
                .and_then(|()| layout.append(&file, Filled::default(), frame))
                .map_err(|error| h5::explain("write", partial, &error))?;
            h5::close(file, partial)
        })?;
        self.closed = number;
        self.frames_closed += self.filled.frames;
        self.filled = layout.and(Filled::default(), frame.rows());
        (self.layout, self.is_of_now, self.rows, self.twin) = (layout, true, rows, None);
        Ok(())
    }

    /// The part that grows.
    fn growing(&self) -> PathBuf {
        part(&self.path, self.closed)
    }

    /// Frames in all parts.
    pub fn frames(&self) -> usize {
        self.frames_closed + self.filled.frames
    }

    /// Where the first part is.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// Changes a file that has no name yet.
fn change(
    path: &Path,
    action: &'static str,
    change: impl FnOnce(&hdf5::File) -> hdf5::Result<()>,
) -> Result<(), Error> {
    let file = h5::open(path, true)?;
    change(&file).map_err(|error| h5::explain(action, path, &error))?;
    h5::close(file, path)
}

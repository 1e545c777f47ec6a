//! What all frames of a file have in common.

use std::fmt;

use super::{Drawn, Frame};
use crate::column::{Column, Kind, assert_name};

/// One field as the file declares it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Field {
    pub name: String,
    pub width: usize,
    pub kind: Kind,
}

/// What all frames of a file have in common.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Shape {
    pub drawn: Drawn,
    pub fields: Vec<Field>,
    pub whole: Vec<Field>,
}

impl Shape {
    /// Panics if a field is neither `f64` nor `i64`, or has not a row per point or line.
    pub fn of(frame: &Frame) -> Shape {
        let (rows, per_row) = (frame.rows(), frame.drawn.positions());
        assert!(frame.positions.len() == rows * per_row, "frame: a line lacks an end");
        let fields: Vec<Field> = frame.fields.iter().map(|column| declare(column, rows)).collect();
        let whole: Vec<Field> = frame.whole.iter().map(|column| declare(column, 1)).collect();
        assert!(whole.iter().all(|field| field.kind == Kind::F64), "frame: what is of the whole must be f64");
        for fields in [&fields, &whole] {
            for (index, field) in fields.iter().enumerate() {
                assert!(
                    fields[..index].iter().all(|other| other.name != field.name),
                    "frame: field {} twice",
                    field.name
                );
            }
        }
        Shape { drawn: frame.drawn, fields, whole }
    }
}

fn declare(column: &Column, rows: usize) -> Field {
    assert_name(&column.name);
    column.assert_shape("frame", rows);
    let kind = column.values.kind();
    assert!(matches!(kind, Kind::F64 | Kind::I64), "frame: field {} must be f64 or i64, not {kind}", column.name);
    Field { name: column.name.clone(), width: column.width, kind }
}

/// The fields in words, for a message.
impl fmt::Display for Shape {
    fn fmt(&self, to: &mut fmt::Formatter) -> fmt::Result {
        let words = |fields: &[Field]| -> String {
            let words = fields.iter().map(|field| format!("{}: {} x {}", field.name, field.width, field.kind));
            words.collect::<Vec<_>>().join(", ")
        };
        write!(to, "{}", words(&self.fields))?;
        if !self.whole.is_empty() {
            write!(to, "; of the whole {}", words(&self.whole))?;
        }
        match self.drawn {
            Drawn::Points => Ok(()),
            Drawn::Lines => write!(to, "; of lines"),
            Drawn::Quadrilaterals => write!(to, "; of quadrilaterals"),
        }
    }
}

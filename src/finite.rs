//! JSON of results: a number that is NaN or infinite is an error with its path. JSON cannot represent it, and
//! the writer's `null` would later pass for "not measured".

use std::fmt;

use serde::ser::{self, Serialize};

/// A number that is NaN or infinite.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{} is {value}", if path.is_empty() { "the value" } else { path.as_str() })]
pub struct NotFinite {
    /// Its path: `episodes.3.speed`.
    pub path: String,
    /// `NaN`, `inf` or `-inf`.
    pub value: String,
}

/// Checks every number of a value.
pub fn check<T: Serialize + ?Sized>(value: &T) -> Result<(), NotFinite> {
    value.serialize(Search { path: &mut Vec::new() }).map_err(|found| match found {
        Found::Number(found) => found,
        // A key that is not a text, or a serializer's own error: `serde_json` meets it too and reports it.
        Found::Other(reason) => NotFinite { path: String::new(), value: reason },
    })
}

/// A value as one line of JSON.
pub fn to_string<T: Serialize + ?Sized>(value: &T) -> Result<String, NotFinite> {
    check(value)?;
    serde_json::to_string(value).map_err(unwritable)
}

/// A value as indented JSON.
pub fn to_string_pretty<T: Serialize + ?Sized>(value: &T) -> Result<String, NotFinite> {
    check(value)?;
    serde_json::to_string_pretty(value).map_err(unwritable)
}

#[expect(clippy::needless_pass_by_value, reason = "`map_err` hands it over")]
fn unwritable(error: serde_json::Error) -> NotFinite {
    NotFinite { path: String::new(), value: error.to_string() }
}

/// Why the search ended early.
#[derive(Debug)]
enum Found {
    Number(NotFinite),
    Other(String),
}

impl fmt::Display for Found {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Number(found) => found.fmt(formatter),
            Self::Other(reason) => formatter.write_str(reason),
        }
    }
}

impl std::error::Error for Found {}

impl ser::Error for Found {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self::Other(message.to_string())
    }
}

/// A serializer that writes nothing and tracks its path.
struct Search<'a> {
    path: &'a mut Vec<String>,
}

impl Search<'_> {
    fn number(self, value: f64) -> Result<(), Found> {
        if value.is_finite() {
            return Ok(());
        }
        Err(Found::Number(NotFinite { path: self.path.join("."), value: value.to_string() }))
    }

    fn inner(&mut self) -> Search<'_> {
        Search { path: self.path }
    }
}

/// A list, a tuple, a map or a structure.
struct Compound<'a> {
    path: &'a mut Vec<String>,
    next: usize,
    key: String,
}

impl Compound<'_> {
    fn at<T: Serialize + ?Sized>(&mut self, step: String, value: &T) -> Result<(), Found> {
        self.path.push(step);
        value.serialize(Search { path: self.path })?;
        self.path.pop();
        Ok(())
    }

    fn item<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Found> {
        let step = self.next.to_string();
        self.next += 1;
        self.at(step, value)
    }
}

impl<'a> Search<'a> {
    fn compound(self) -> Result<Compound<'a>, Found> {
        Ok(Compound { path: self.path, next: 0, key: String::new() })
    }
}

macro_rules! nothing {
    ($($method:ident: $kind:ty),* $(,)?) => {
        $(fn $method(self, _: $kind) -> Result<(), Found> { Ok(()) })*
    };
}

impl<'a> ser::Serializer for Search<'a> {
    type Ok = ();
    type Error = Found;
    type SerializeSeq = Compound<'a>;
    type SerializeTuple = Compound<'a>;
    type SerializeTupleStruct = Compound<'a>;
    type SerializeTupleVariant = Compound<'a>;
    type SerializeMap = Compound<'a>;
    type SerializeStruct = Compound<'a>;
    type SerializeStructVariant = Compound<'a>;

    nothing! {
        serialize_bool: bool, serialize_i8: i8, serialize_i16: i16, serialize_i32: i32, serialize_i64: i64,
        serialize_i128: i128, serialize_u8: u8, serialize_u16: u16, serialize_u32: u32, serialize_u64: u64,
        serialize_u128: u128, serialize_char: char, serialize_str: &str, serialize_bytes: &[u8],
    }

    fn serialize_f32(self, value: f32) -> Result<(), Found> {
        self.number(value.into())
    }

    fn serialize_f64(self, value: f64) -> Result<(), Found> {
        self.number(value)
    }

    fn serialize_none(self) -> Result<(), Found> {
        Ok(())
    }

    fn serialize_some<T: Serialize + ?Sized>(mut self, value: &T) -> Result<(), Found> {
        value.serialize(self.inner())
    }

    fn serialize_unit(self) -> Result<(), Found> {
        Ok(())
    }

    fn serialize_unit_struct(self, _: &'static str) -> Result<(), Found> {
        Ok(())
    }

    fn serialize_unit_variant(self, _: &'static str, _: u32, _: &'static str) -> Result<(), Found> {
        Ok(())
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        mut self,
        _: &'static str,
        value: &T,
    ) -> Result<(), Found> {
        value.serialize(self.inner())
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        value: &T,
    ) -> Result<(), Found> {
        self.compound()?.at(variant.to_owned(), value)
    }

    fn serialize_seq(self, _: Option<usize>) -> Result<Compound<'a>, Found> {
        self.compound()
    }

    fn serialize_tuple(self, _: usize) -> Result<Compound<'a>, Found> {
        self.compound()
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Compound<'a>, Found> {
        self.compound()
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Compound<'a>, Found> {
        self.compound()
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Compound<'a>, Found> {
        self.compound()
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Compound<'a>, Found> {
        self.compound()
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Compound<'a>, Found> {
        self.compound()
    }
}

macro_rules! items {
    ($($kind:ident: $method:ident),* $(,)?) => {
        $(impl ser::$kind for Compound<'_> {
            type Ok = ();
            type Error = Found;

            fn $method<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Found> {
                self.item(value)
            }

            fn end(self) -> Result<(), Found> {
                Ok(())
            }
        })*
    };
}

macro_rules! fields {
    ($($kind:ident),*) => {
        $(impl ser::$kind for Compound<'_> {
            type Ok = ();
            type Error = Found;

            fn serialize_field<T: Serialize + ?Sized>(&mut self, key: &'static str, value: &T) -> Result<(),
            Found> {
                self.at(key.to_owned(), value)
            }

            fn end(self) -> Result<(), Found> {
                Ok(())
            }
        })*
    };
}

items! {
    SerializeSeq: serialize_element, SerializeTuple: serialize_element, SerializeTupleStruct: serialize_field,
    SerializeTupleVariant: serialize_field,
}
fields!(SerializeStruct, SerializeStructVariant);

impl ser::SerializeMap for Compound<'_> {
    type Ok = ();
    type Error = Found;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Result<(), Found> {
        self.key =
            serde_json::to_string(key).map_err(|error| Found::Other(error.to_string()))?.replace('"', "");
        Ok(())
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Found> {
        let key = std::mem::take(&mut self.key);
        self.at(key, value)
    }

    fn end(self) -> Result<(), Found> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use serde::Serialize;

    use super::*;

    #[derive(Serialize)]
    enum Shape {
        Point,
        Circle(f64),
        Box { width: f32 },
        Pair(u8, f64),
    }

    #[derive(Serialize)]
    struct Sample {
        mean: Option<f64>,
        by_name: BTreeMap<&'static str, f64>,
        shapes: Vec<Shape>,
        bounds: [f64; 2],
    }

    /// The path of a number, its value, and the function that sets it.
    type Case = (&'static str, &'static str, fn(&mut Sample));

    fn sample() -> Sample {
        let shapes = vec![Shape::Point, Shape::Circle(1.0), Shape::Box { width: 1.0 }, Shape::Pair(1, 2.0)];
        Sample { mean: None, by_name: BTreeMap::from([("a", 1.0)]), shapes, bounds: [f64::MIN, f64::MAX] }
    }

    #[test]
    fn a_number_that_is_not_finite_is_refused_wherever_it_stands() {
        assert_eq!(to_string(&sample()).unwrap(), serde_json::to_string(&sample()).unwrap());
        let broken: [Case; 7] = [
            ("mean", "NaN", |sample| sample.mean = Some(f64::NAN)),
            ("by_name.b", "inf", |sample| *sample.by_name.entry("b").or_default() = f64::INFINITY),
            ("shapes.1.Circle", "-inf", |sample| sample.shapes[1] = Shape::Circle(f64::NEG_INFINITY)),
            ("shapes.2.width", "NaN", |sample| sample.shapes[2] = Shape::Box { width: f32::NAN }),
            ("shapes.3.1", "NaN", |sample| sample.shapes[3] = Shape::Pair(0, f64::NAN)),
            ("bounds.1", "inf", |sample| sample.bounds[1] = f64::INFINITY),
            ("shapes.0.width", "inf", |sample| sample.shapes[0] = Shape::Box { width: f32::INFINITY }),
        ];
        for (path, value, breaks) in broken {
            let mut sample = sample();
            breaks(&mut sample);
            let expected = NotFinite { path: path.into(), value: value.into() };
            assert_eq!(to_string(&sample), Err(expected.clone()));
            assert_eq!(to_string_pretty(&sample), Err(expected));
        }
        assert_eq!(check(&f64::NAN).unwrap_err().to_string(), "the value is NaN");
    }
}

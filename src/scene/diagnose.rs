//! The second reading of a scene that `ron` refuses: every mistake in one go.
//!
//! It reads the tree of the [scanner](super::scan), so it knows the path and the place of all it
//! touches, notes each mistake and goes on with what was probably meant or with a
//! [stand-in](super::stand_in). What it accepts is not decided here but by `ron` before.

use std::cell::RefCell;
use std::fmt;

use serde::Deserialize;
use serde::de::value::StrDeserializer;
use serde::de::{self, DeserializeOwned, DeserializeSeed, IntoDeserializer, Visitor};

use super::diagnostic::{Finding, MOST, Placed};
use super::format::{Scene, VERSION};
use super::scan::{Entry, Key, Node, Shape, scan};
use super::spans::join;
use super::stand_in::StandIn;
use super::suggest;

/// What the second reading found.
pub(super) struct Diagnosis {
    /// The scene as it was probably meant.
    pub scene: Option<Scene>,
    /// The mistakes.
    pub placed: Vec<Placed>,
    /// Paths of values that were made up: what follows from them is no news.
    pub made_up: Vec<String>,
    /// Misspelt fields: the path as it was meant and as it is written.
    pub renamed: Vec<(String, String)>,
}

/// Reads a text that `ron` refused.
pub(super) fn diagnose(text: &str) -> Diagnosis {
    let (root, faults) = scan(text);
    let faults: Vec<_> = faults
        .into_iter()
        .map(|fault| Placed { at: fault.at, finding: Finding::new("", fault.message, fault.help) })
        .collect();
    let Some(root) = root else {
        return Diagnosis { scene: None, placed: faults, made_up: Vec::new(), renamed: Vec::new() };
    };
    // A missing field stops serde, so it is noted, made up and the reading is repeated.
    let mut missing: Vec<Placed> = Vec::new();
    let mut absent: Vec<String> = Vec::new();
    loop {
        let cx = Context { text, absent: &absent, notes: RefCell::default() };
        let reader = Reader { cx: &cx, node: &root, path: String::new(), inside: false };
        let result = Scene::deserialize(reader);
        let notes = cx.notes.into_inner();
        let failure = result.as_ref().err().map(Failure::placed);
        match failure {
            Some(Some((path, placed))) if missing.len() < MOST => {
                missing.push(placed);
                absent.push(path);
            }
            _ => {
                let placed = faults.into_iter().chain(missing).chain(notes.placed).collect();
                let made_up = notes.made_up.into_iter().chain(absent).collect();
                let scene = result.ok();
                return Diagnosis { scene, placed, made_up, renamed: notes.renamed };
            }
        }
    }
}

struct Context<'a> {
    text: &'a str,
    /// Paths of missing fields that are to be made up.
    absent: &'a [String],
    notes: RefCell<Notes>,
}

#[derive(Default)]
struct Notes {
    placed: Vec<Placed>,
    made_up: Vec<String>,
    renamed: Vec<(String, String)>,
}

impl Context<'_> {
    fn note(&self, at: usize, path: &str, message: String, help: impl Into<String>) {
        let finding = Finding::new(path, message, help);
        self.notes.borrow_mut().placed.push(Placed { at, finding });
    }

    fn literal(&self, node: &Node) -> &str {
        self.text.get(node.span.clone()).unwrap_or_default()
    }

    /// A value in a message.
    fn found(&self, node: &Node) -> String {
        const LONGEST: usize = 40;
        let literal = self.literal(node);
        let name = node.name.clone().and_then(|name| self.text.get(name));
        match node.shape {
            Shape::Nothing => "nothing".to_owned(),
            _ if literal.chars().count() <= LONGEST && !literal.contains('\n') => {
                format!("`{literal}`")
            }
            _ if name.is_some() => format!("`{}(...)`", name.unwrap_or_default()),
            Shape::List => "a list `[...]`".to_owned(),
            Shape::Map => "a map `{...}`".to_owned(),
            Shape::Struct => "named fields `(name: ...)`".to_owned(),
            Shape::Tuple => "values in brackets `(...)`".to_owned(),
            _ => format!("`{}...`", literal.chars().take(LONGEST).collect::<String>()),
        }
    }
}

/// Why serde stopped: in practice a missing field.
#[derive(Debug)]
pub(super) struct Failure {
    field: Option<&'static str>,
    message: String,
    place: Option<(String, usize)>,
}

impl Failure {
    /// Ties the failure to the struct that it arose in.
    fn inside(mut self, path: &str, at: usize) -> Self {
        self.place.get_or_insert_with(|| (path.to_owned(), at));
        self
    }

    /// Path and finding of a missing field.
    fn placed(&self) -> Option<(String, Placed)> {
        let (path, at) = self.place.as_ref()?;
        let field = self.field?;
        let path = join(path, field);
        let help = match unit(field) {
            _ if field == "version" => format!("add `version: {VERSION}`"),
            Some(unit) => format!("add `{field}: ...`, {unit}"),
            None => format!("add `{field}: ...`"),
        };
        let finding = Finding::new(&path, format!("missing field `{field}`"), help);
        Some((path, Placed { at: *at, finding }))
    }
}

/// Units of the fields that cannot be left out.
fn unit(field: &str) -> Option<&'static str> {
    Some(match field {
        "radius" | "spacing" | "length" | "step" => "in m",
        "position" | "start" | "end" | "min" | "max" => "as (x, y) in m",
        "limits" => "as (smallest, greatest) in m",
        "dt" => "in s",
        "cohesion" | "tensile_strength" | "stress" => "in Pa",
        "increments" | "columns" | "rows" | "count" => "a number from 1",
        _ => return None,
    })
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Failure {}

impl de::Error for Failure {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self { field: None, message: message.to_string(), place: None }
    }

    fn missing_field(field: &'static str) -> Self {
        Self { field: Some(field), message: format!("missing field `{field}`"), place: None }
    }
}

/// Reads one value of the tree.
struct Reader<'a> {
    cx: &'a Context<'a>,
    node: &'a Node,
    path: String,
    /// Whether the name before the brackets is already dealt with: a variant that wraps a struct.
    inside: bool,
}

impl<'a> Reader<'a> {
    /// Notes that something else was expected here, and makes it up.
    fn expected(&self, what: &str) -> StandIn {
        let message = format!("expected {what}, found {}", self.cx.found(self.node));
        self.cx.note(self.node.span.start, &self.path, message, "");
        self.cx.notes.borrow_mut().made_up.push(self.path.clone());
        StandIn
    }

    fn scalar<T: DeserializeOwned>(&self, shapes: &[Shape]) -> Option<T> {
        let fits = shapes.contains(&self.node.shape);
        fits.then(|| ron::from_str(self.cx.literal(self.node)).ok())?
    }

    fn named(&self) -> Option<&'a str> {
        self.cx.text.get(self.node.name.clone()?)
    }

    fn fields<V: Visitor<'a>>(
        self,
        allowed: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Failure> {
        let at = self.node.span.start;
        let fields = Fields { reader: &self, allowed, given: Vec::new(), next: 0, value: None };
        visitor.visit_map(fields).map_err(|failure| failure.inside(&self.path, at))
    }

    fn values<V: Visitor<'a>>(self, length: usize, visitor: V) -> Result<V::Value, Failure> {
        let found = self.node.entries.len();
        if found == length {
            return visitor.visit_seq(Items { reader: &self, next: 0 });
        }
        let stand_in = self.expected(&format!("{length} values in brackets"));
        de::Deserializer::deserialize_tuple(stand_in, length, visitor)
    }
}

macro_rules! scalars {
    ($($method:ident $visit:ident $type:ty, $shapes:expr, $what:expr;)*) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
            match self.scalar::<$type>(&$shapes) {
                Some(value) => visitor.$visit(value),
                None => self.expected($what).$method(visitor),
            }
        }
    )*};
}

impl<'de> de::Deserializer<'de> for Reader<'de> {
    type Error = Failure;

    scalars! {
        deserialize_bool visit_bool bool, [Shape::Word], "`true` or `false`";
        deserialize_u32 visit_u32 u32, [Shape::Number], "a whole number from 0 to 4294967295";
        deserialize_u64 visit_u64 u64, [Shape::Number], "a whole number from 0";
        deserialize_f64 visit_f64 f64, [Shape::Number, Shape::Word], "a number";
        deserialize_string visit_string String, [Shape::Text], "a text in quotes";
        deserialize_str visit_string String, [Shape::Text], "a text in quotes";
    }

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        visitor.visit_unit()
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        if self.node.shape == Shape::Word && self.cx.literal(self.node) == "None" {
            return visitor.visit_none();
        }
        match self.node.entries.as_slice() {
            [Entry { key: None, value }] if self.named() == Some("Some") => {
                visitor.visit_some(Reader { node: value, ..self })
            }
            _ => {
                let inside = self.named() == Some("Some");
                visitor.visit_some(Reader { inside, ..self })
            }
        }
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        if self.node.shape == Shape::List {
            visitor.visit_seq(Items { reader: &self, next: 0 })
        } else {
            self.expected("a list `[...]`").deserialize_seq(visitor)
        }
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Failure> {
        if self.node.shape == Shape::Tuple && (self.inside || self.node.name.is_none()) {
            return self.values(length, visitor);
        }
        let what = format!("{length} values in round brackets `(...)`");
        self.expected(&what).deserialize_tuple(length, visitor)
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        if self.node.shape == Shape::Map {
            visitor.visit_map(Pairs { reader: &self, next: 0 })
        } else {
            self.expected("a map `{\"name\": ...}`").deserialize_map(visitor)
        }
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Failure> {
        let shape = self.node.shape;
        let brackets =
            shape == Shape::Struct || (shape == Shape::Tuple && self.node.entries.is_empty());
        let other_name = !self.inside && self.named().is_some_and(|found| found != name);
        if other_name || !brackets {
            let what = format!("`({}: ...)`", fields.first().copied().unwrap_or_default());
            return self.expected(&what).deserialize_struct(name, fields, visitor);
        }
        self.fields(fields, visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Failure> {
        let word = match self.node.shape {
            Shape::Word => Some(self.cx.literal(self.node)),
            _ => self.named().filter(|_| !self.inside),
        };
        let Some(word) = word else {
            let what = format!("one of {}", suggest::list(variants));
            return self.expected(&what).deserialize_enum(name, variants, visitor);
        };
        let (known, meant) = match variants.iter().find(|variant| **variant == word) {
            Some(variant) => (true, Some(*variant)),
            None => (false, suggest::nearest(word, variants.iter().copied())),
        };
        if !known {
            let message = format!("unknown variant `{word}`");
            let help = suggest::help(word, variants, "variants");
            self.cx.note(self.node.span.start, &self.path, message, help);
        }
        if let Some(variant) = meant {
            visitor.visit_enum(Variant { name: variant, reader: self })
        } else {
            self.cx.notes.borrow_mut().made_up.push(self.path);
            StandIn.deserialize_enum(name, variants, visitor)
        }
    }

    serde::forward_to_deserialize_any! {
        i8 i16 i32 i64 u8 u16 f32 char bytes byte_buf unit unit_struct newtype_struct
        tuple_struct identifier ignored_any
    }
}

/// Items of a list or a tuple.
struct Items<'r, 'a> {
    reader: &'r Reader<'a>,
    next: usize,
}

impl<'a> de::SeqAccess<'a> for Items<'_, 'a> {
    type Error = Failure;

    fn next_element_seed<S: DeserializeSeed<'a>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, Failure> {
        let Reader { cx, node, path, .. } = self.reader;
        let Some(entry) = node.entries.get(self.next) else { return Ok(None) };
        let path = format!("{path}[{}]", self.next);
        self.next += 1;
        seed.deserialize(Reader { cx, node: &entry.value, path, inside: false }).map(Some)
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.reader.node.entries.len() - self.next)
    }
}

/// Entries of a map with text keys.
struct Pairs<'r, 'a> {
    reader: &'r Reader<'a>,
    next: usize,
}

impl<'a> de::MapAccess<'a> for Pairs<'_, 'a> {
    type Error = Failure;

    fn next_key_seed<S: DeserializeSeed<'a>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, Failure> {
        let Reader { cx, node, path, .. } = self.reader;
        loop {
            let Some(Entry { key: Some(key), .. }) = node.entries.get(self.next) else {
                return Ok(None);
            };
            self.next += 1;
            let path = join(path, &key.text);
            if !key.quoted {
                let help = format!("write `\"{}\"`", key.text);
                cx.note(key.span.start, &path, "a key without quotes".to_owned(), help);
            }
            let earlier = node.entries.iter().take(self.next - 1);
            if earlier.filter_map(|entry| entry.key.as_ref()).any(|other| other.text == key.text) {
                let message = format!("`{}` is given twice", key.text);
                cx.note(key.span.start, &path, message, "give it once");
                continue;
            }
            let name: StrDeserializer<'_, Failure> = key.text.as_str().into_deserializer();
            return seed.deserialize(name).map(Some);
        }
    }

    fn next_value_seed<S: DeserializeSeed<'a>>(&mut self, seed: S) -> Result<S::Value, Failure> {
        let Reader { cx, node, path, .. } = self.reader;
        match node.entries.get(self.next.wrapping_sub(1)) {
            Some(Entry { key: Some(key), value }) => {
                let path = join(path, &key.text);
                seed.deserialize(Reader { cx, node: value, path, inside: false })
            }
            _ => seed.deserialize(StandIn),
        }
    }
}

/// Fields of a struct, with unknown and repeated ones sorted out.
struct Fields<'r, 'a> {
    reader: &'r Reader<'a>,
    allowed: &'static [&'static str],
    given: Vec<&'static str>,
    next: usize,
    /// Value of the field whose name was handed out last; none is made up.
    value: Option<(&'a Node, &'static str)>,
}

impl<'a> Fields<'_, 'a> {
    /// The field that a key means.
    fn meant(&self, key: &Key) -> Option<&'static str> {
        let Reader { cx, node, path, .. } = self.reader;
        let at = key.span.start;
        if let Some(field) = self.allowed.iter().find(|field| **field == key.text) {
            if self.given.contains(field) {
                let message = format!("`{field}` is given twice");
                cx.note(at, &join(path, field), message, "give it once");
                return None;
            }
            return Some(*field);
        }
        let meant = suggest::nearest(&key.text, self.allowed.iter().copied());
        let list = suggest::list(self.allowed);
        let help = match meant {
            Some(field) => format!("did you mean `{field}`? the fields here are {list}"),
            None => format!("the fields here are {list}"),
        };
        cx.note(at, &join(path, &key.text), format!("unknown field `{}`", key.text), help);
        let keys = || node.entries.iter().filter_map(|entry| entry.key.as_ref());
        let open = |field: &&str| {
            !self.given.contains(field) && keys().all(|key| key.text != **field)
        };
        let meant = meant.filter(open);
        if let Some(field) = meant {
            let renaming = (join(path, field), join(path, &key.text));
            cx.notes.borrow_mut().renamed.push(renaming);
        }
        meant
    }
}

impl<'a> de::MapAccess<'a> for Fields<'_, 'a> {
    type Error = Failure;

    fn next_key_seed<S: DeserializeSeed<'a>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, Failure> {
        let Reader { cx, node, path, .. } = self.reader;
        let mut field = None;
        while let Some(entry) = node.entries.get(self.next) {
            self.next += 1;
            if let Some(key) = &entry.key {
                field = self.meant(key);
                self.value = field.map(|field| (&entry.value, field));
                if field.is_some() {
                    break;
                }
            } else {
                let message = format!("expected `name: value`, found {}", cx.found(&entry.value));
                cx.note(entry.value.span.start, path, message, "");
            }
        }
        if field.is_none() {
            let absent = |field: &&&str| {
                !self.given.contains(field) && cx.absent.contains(&join(path, field))
            };
            field = self.allowed.iter().find(absent).copied();
            self.value = None;
        }
        let Some(field) = field else { return Ok(None) };
        self.given.push(field);
        let name: StrDeserializer<'_, Failure> = field.into_deserializer();
        seed.deserialize(name).map(Some)
    }

    fn next_value_seed<S: DeserializeSeed<'a>>(&mut self, seed: S) -> Result<S::Value, Failure> {
        match self.value.take() {
            Some((node, field)) => {
                let path = join(&self.reader.path, field);
                seed.deserialize(Reader { cx: self.reader.cx, node, path, inside: false })
            }
            None => seed.deserialize(StandIn),
        }
    }
}

struct Variant<'a> {
    name: &'static str,
    reader: Reader<'a>,
}

impl<'a> de::EnumAccess<'a> for Variant<'a> {
    type Error = Failure;
    type Variant = Self;

    fn variant_seed<S: DeserializeSeed<'a>>(self, seed: S) -> Result<(S::Value, Self), Failure> {
        let name: StrDeserializer<'_, Failure> = self.name.into_deserializer();
        Ok((seed.deserialize(name)?, self))
    }
}

impl<'a> de::VariantAccess<'a> for Variant<'a> {
    type Error = Failure;

    fn unit_variant(self) -> Result<(), Failure> {
        if self.reader.node.name.is_some() {
            self.reader.expected(&format!("plain `{}`", self.name));
        }
        Ok(())
    }

    fn newtype_variant_seed<S: DeserializeSeed<'a>>(self, seed: S) -> Result<S::Value, Failure> {
        let reader = self.reader;
        match reader.node.entries.as_slice() {
            [Entry { key: None, value }] => {
                let group = super::spans::is_group(value);
                let path = if group { reader.path } else { format!("{}[0]", reader.path) };
                seed.deserialize(Reader { cx: reader.cx, node: value, path, inside: false })
            }
            _ if reader.node.shape == Shape::Word => {
                let stand_in = reader.expected(&format!("`{}(...)`", self.name));
                seed.deserialize(stand_in)
            }
            _ => seed.deserialize(Reader { inside: true, ..reader }),
        }
    }

    fn tuple_variant<V: Visitor<'a>>(
        self,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Failure> {
        self.reader.values(length, visitor)
    }

    fn struct_variant<V: Visitor<'a>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Failure> {
        let unnamed = |entry: &Entry| entry.key.is_none();
        if self.reader.node.entries.iter().any(unnamed) {
            let first = fields.first().copied().unwrap_or_default();
            let stand_in = self.reader.expected(&format!("`{}({first}: ...)`", self.name));
            return de::Deserializer::deserialize_struct(stand_in, "", fields, visitor);
        }
        self.reader.fields(fields, visitor)
    }
}


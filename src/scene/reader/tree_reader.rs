//! A serde deserializer over the tree of the [scanner](super::scan).
//!
//! A mistake is recorded in the [`Context`] with its path and place, and the reading continues.

use serde::de::value::StrDeserializer;
use serde::de::{self, DeserializeOwned, DeserializeSeed, IntoDeserializer, Visitor};

use super::context::{Context, Failure};
use super::scan::{Entry, Key, Node, Shape};
use super::spans::{is_group, join};
use super::stand_in::StandIn;
use super::suggest;
use super::units;
use crate::scene::format::WITHOUT_BRACKETS;
use crate::scene::values;

/// Reads one value of the tree.
pub(super) struct Reader<'a> {
    cx: &'a Context<'a>,
    node: &'a Node,
    path: String,
    /// Whether the name before the brackets has been read: a variant that contains a struct.
    inside: bool,
    /// Unit of the numbers inside; see [`units::unit_of`].
    unit: Option<&'static str>,
}

impl<'a> Reader<'a> {
    pub(super) fn new(cx: &'a Context<'a>, node: &'a Node, path: String) -> Self {
        Self { cx, node, path, inside: false, unit: None }
    }

    /// Sets the field or variant to which the numbers inside belong.
    fn named_for(self, name: &str) -> Self {
        let unit = units::unit_of(name, self.unit);
        Self { unit, ..self }
    }

    /// Records that another kind of value was expected, and makes up a value.
    fn expected(&self, what: &str) -> StandIn {
        self.expected_with(what, self.meant(what))
    }

    fn expected_with(&self, what: &str, help: impl Into<String>) -> StandIn {
        let message = format!("expected {what}, found {}", self.cx.found(self.node));
        self.cx.note(self.node.span.start, &self.path, message, help);
        self.cx.made_up(self.path.clone());
        StandIn
    }

    /// The remedy, if it can be derived from the value.
    fn meant(&self, what: &str) -> String {
        let literal = self.cx.literal(self.node);
        let number = what.ends_with("number") || what.contains("whole number");
        if number
            && let Some((word, _)) = values::name_of(self.node, self.cx.text)
            && !self.cx.values.is_empty()
        {
            return values::help(word, self.cx.values);
        }
        match self.node.shape {
            Shape::Number if number => match (units::split(literal), literal.parse::<f64>()) {
                (Some((value, unit)), _) => units::help(value, unit, self.unit),
                (_, Ok(value)) if value >= 0.0 && value.fract() == 0.0 && value < 1e9 => {
                    format!("write {value:.0}")
                }
                (_, Ok(value)) if value > 1.0 && value < 1e9 && what.contains("whole") => {
                    format!("write {:.0} or {:.0}", value.floor(), value.ceil())
                }
                _ => String::new(),
            },
            Shape::Tuple if number => match self.node.entries.as_slice() {
                [Entry { key: None, value }]
                    if self.named() == Some("Some") && value.shape == Shape::Number =>
                {
                    format!("write `{}`, without `Some`", self.cx.literal(value))
                }
                [_, _, ..] => "give one number".to_owned(),
                _ => String::new(),
            },
            Shape::Nothing if self.path.is_empty() => {
                "there is nothing but comments in it; `clastic list` shows scenes to start from"
                    .into()
            }
            Shape::Text if number => "leave the quotes out".to_owned(),
            Shape::Word | Shape::Number | Shape::Char if what.starts_with("a text") => {
                format!("write `\"{}\"`", literal.trim_matches('\''))
            }
            Shape::Text if what.starts_with("a text") && literal.contains('\\') => {
                "a backslash in a text is written twice, `\\\\`; in paths `/` will do".to_owned()
            }
            Shape::Tuple if what.starts_with("a list") && self.node.name.is_none() => {
                "write `[` and `]` for `(` and `)`".to_owned()
            }
            Shape::Map if what.starts_with("a list") => {
                "items of a list are in `[` and `]`, with no name before them".to_owned()
            }
            _ => String::new(),
        }
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
        match self.node.shape {
            Shape::List => visitor.visit_seq(Items { reader: &self, next: 0 }),
            _ => visitor.visit_newtype_struct(self),
        }
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
        const MAP: &str = "a map `{\"name\": ...}`";
        let keys = || self.node.entries.iter().filter_map(|entry| entry.key.as_ref());
        match self.node.shape {
            Shape::Map => visitor.visit_map(Pairs { reader: &self, next: 0 }),
            // The struct was meant as a map if its names are those of a map.
            Shape::Struct if self.node.name.is_none() && keys().all(|key| key.quoted) => {
                let message = format!("expected {MAP}, found {}", self.cx.found(self.node));
                let help = "write `{` and `}` for `(` and `)`";
                self.cx.note(self.node.span.start, &self.path, message, help);
                visitor.visit_map(Pairs { reader: &self, next: 0 })
            }
            _ => self.expected(MAP).deserialize_map(visitor),
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
            let help = match self.node.entries.as_slice() {
                [Entry { key: None, value }] if value.shape == Shape::Struct => {
                    "leave out one pair of brackets".to_owned()
                }
                _ if shape == Shape::Tuple && !other_name => {
                    format!("write `name: value`; the fields here are {}", suggest::list(fields))
                }
                _ => self.meant(&what),
            };
            return self.expected_with(&what, help).deserialize_struct(name, fields, visitor);
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
            self.cx.made_up(self.path);
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
        let Reader { cx, node, path, unit, .. } = self.reader;
        let Some(entry) = node.entries.get(self.next) else { return Ok(None) };
        let path = format!("{path}[{}]", self.next);
        self.next += 1;
        let item = Reader { unit: *unit, ..Reader::new(cx, &entry.value, path) };
        seed.deserialize(item).map(Some)
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
            let Some(entry) = node.entries.get(self.next) else { return Ok(None) };
            self.next += 1;
            let Some(key) = &entry.key else {
                let message =
                    format!("expected `\"name\": value`, found {}", cx.found(&entry.value));
                cx.note(entry.value.span.start, path, message, "put a name and `:` before it");
                continue;
            };
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
                seed.deserialize(Reader::new(cx, value, path))
            }
            _ => seed.deserialize(StandIn),
        }
    }
}

/// Fields of a struct without unknown and repeated fields, which are recorded.
struct Fields<'r, 'a> {
    reader: &'r Reader<'a>,
    allowed: &'static [&'static str],
    given: Vec<&'static str>,
    next: usize,
    /// Value of the last returned field; `None` means a value to be made up.
    value: Option<(&'a Node, &'static str)>,
}

impl<'a> Fields<'_, 'a> {
    /// The field that a key stands for.
    fn meant(&self, key: &Key) -> Option<&'static str> {
        let Reader { cx, node, path, .. } = self.reader;
        let at = key.span.start;
        if key.quoted {
            let message = "a field name in quotes".to_owned();
            cx.note(at, &join(path, &key.text), message, "leave the quotes out");
        }
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
        let open =
            |field: &&str| !self.given.contains(field) && keys().all(|key| key.text != **field);
        let meant = meant.filter(open);
        if let Some(field) = meant {
            cx.renamed(join(path, field), join(path, &key.text));
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
                let number = |entry: &Entry| entry.value.shape == Shape::Number;
                let before = node.entries.get(self.next.wrapping_sub(2));
                let help = if number(entry) && before.is_some_and(number) {
                    "a decimal has a point, no comma"
                } else {
                    ""
                };
                cx.note(entry.value.span.start, path, message, help);
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
                seed.deserialize(Reader::new(self.reader.cx, node, path).named_for(field))
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
        let reader = self.reader.named_for(self.name);
        match reader.node.entries.as_slice() {
            [Entry { key: None, value }] => {
                let group = is_group(value);
                let path = if group { reader.path } else { format!("{}[0]", reader.path) };
                seed.deserialize(Reader { node: value, path, inside: false, ..reader })
            }
            _ if reader.node.shape == Shape::Word => {
                let stand_in = reader.expected(&format!("`{}(...)`", self.name));
                seed.deserialize(stand_in)
            }
            _ => seed.deserialize(Reader { inside: true, ..reader }),
        }
    }

    fn tuple_variant<V: Visitor<'a>>(self, length: usize, visitor: V) -> Result<V::Value, Failure> {
        self.reader.named_for(self.name).values(length, visitor)
    }

    fn struct_variant<V: Visitor<'a>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Failure> {
        let unnamed = |entry: &Entry| entry.key.is_none();
        if self.reader.node.shape == Shape::Word && self.name == WITHOUT_BRACKETS {
            // No mistake: whoever reads the variant takes the defaults.
            return Err(de::Error::custom("no brackets"));
        }
        if self.reader.node.shape == Shape::Word {
            let what = format!("`{}(...)`", self.name);
            let help = match fields {
                [] => format!("write `{}()`", self.name),
                _ => format!("its fields are {}", suggest::list(fields)),
            };
            let stand_in = self.reader.expected_with(&what, help);
            return de::Deserializer::deserialize_struct(stand_in, "", fields, visitor);
        }
        if self.reader.node.entries.iter().any(unnamed) {
            let first = fields.first().copied().unwrap_or_default();
            let what = format!("`{}({first}: ...)`", self.name);
            let help = match self.reader.node.entries.as_slice() {
                [Entry { value, .. }] if value.shape == Shape::Struct => {
                    "leave out one pair of brackets".to_owned()
                }
                [Entry { value, .. }] if !is_group(value) => {
                    format!("write `{}({first}: {})`", self.name, self.reader.cx.literal(value))
                }
                _ => format!("write `name: value`; the fields here are {}", suggest::list(fields)),
            };
            let stand_in = self.reader.expected_with(&what, help);
            return de::Deserializer::deserialize_struct(stand_in, "", fields, visitor);
        }
        self.reader.fields(fields, visitor)
    }
}

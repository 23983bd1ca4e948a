//! A JSON document that nobody has checked: every step says where it is, every wrong type is a fault with its place.

use serde_json::Value;

/// What is wrong and where, for a message: `materials[0].alphaCutoff: expected a number, found "x"`.
pub(super) type Fault = String;

/// A value in the document, and how one got there.
#[derive(Clone, Debug)]
pub(super) struct Json<'a> {
    pub(super) value: &'a Value,
    pub(super) place: String,
}

impl<'a> Json<'a> {
    pub(super) fn root(value: &'a Value) -> Self {
        Self { value, place: String::new() }
    }

    /// The fault that something else was expected here.
    pub(super) fn expected(&self, what: &str) -> Fault {
        let found = self.value.to_string();
        let short: String = found.chars().take(40).collect();
        let dots = if short.len() < found.len() { "..." } else { "" };
        format!("{}: expected {what}, found {short}{dots}", self.place)
    }

    /// A fault at this place.
    pub(super) fn fault(&self, what: impl std::fmt::Display) -> Fault {
        format!("{}: {what}", self.place)
    }

    /// A member of an object, if it is there. Null counts as absent.
    pub(super) fn member(&self, key: &str) -> Option<Json<'a>> {
        let value = self.value.get(key).filter(|v| !v.is_null())?;
        let dot = if self.place.is_empty() { "" } else { "." };
        Some(Json { value, place: format!("{}{dot}{key}", self.place) })
    }

    /// A member of an object that must be there.
    pub(super) fn need(&self, key: &str) -> Result<Json<'a>, Fault> {
        self.member(key).ok_or_else(|| self.fault(format_args!("{key:?} is missing")))
    }

    /// A member that must be an object if it is there.
    pub(super) fn object(&self, key: &str) -> Result<Option<Json<'a>>, Fault> {
        match self.member(key) {
            Some(json) if !json.value.is_object() => Err(json.expected("an object")),
            other => Ok(other),
        }
    }

    /// What an extension says about this object.
    pub(super) fn extension(&self, name: &str) -> Result<Option<Json<'a>>, Fault> {
        self.object("extensions")?.map_or(Ok(None), |all| all.object(name))
    }

    /// The items of an array member; none when it is absent.
    pub(super) fn items(&self, key: &str) -> Result<Vec<Json<'a>>, Fault> {
        let Some(json) = self.member(key) else { return Ok(Vec::new()) };
        let Value::Array(values) = json.value else { return Err(json.expected("an array")) };
        Ok(values.iter().enumerate().map(|(i, value)| Json { value, place: format!("{}[{i}]", json.place) }).collect())
    }

    /// How many items an array member has.
    pub(super) fn n_items(&self, key: &str) -> usize {
        self.value.get(key).and_then(Value::as_array).map_or(0, Vec::len)
    }

    /// The item of an array member, as an index found elsewhere says.
    pub(super) fn item(&self, key: &str, i: usize) -> Result<Json<'a>, Fault> {
        let array = self.value.get(key).and_then(Value::as_array);
        let value = array.and_then(|a| a.get(i)).ok_or_else(|| format!("there is no {key}[{i}]"))?;
        let json = Json { value, place: format!("{key}[{i}]") };
        if value.is_object() { Ok(json) } else { Err(json.expected("an object")) }
    }

    /// This as a whole number.
    pub(super) fn as_index(&self) -> Result<usize, Fault> {
        let whole = |x: &f64| *x >= 0.0 && x.fract() == 0.0 && *x < 9.0e15;
        let number = self.value.as_u64().or_else(|| self.value.as_f64().filter(whole).map(|x| x as u64));
        number.and_then(|x| usize::try_from(x).ok()).ok_or_else(|| self.expected("a whole number from 0"))
    }

    /// A member as a whole number.
    pub(super) fn index(&self, key: &str) -> Result<Option<usize>, Fault> {
        self.member(key).map(|json| json.as_index()).transpose()
    }

    /// This as a number that f32 can hold.
    pub(super) fn as_number(&self) -> Result<f64, Fault> {
        let fits = |x: &f64| (*x as f32).is_finite();
        self.value.as_f64().filter(fits).ok_or_else(|| self.expected("a number"))
    }

    /// A member as a number, with a default.
    pub(super) fn number(&self, key: &str, default: f64) -> Result<f64, Fault> {
        self.member(key).map_or(Ok(default), |json| json.as_number())
    }

    /// A member as an array of N numbers, with a default.
    pub(super) fn numbers<const N: usize>(&self, key: &str, default: [f64; N]) -> Result<[f64; N], Fault> {
        let Some(json) = self.member(key) else { return Ok(default) };
        let items = self.items(key)?;
        if items.len() != N {
            return Err(json.expected(&format!("{N} numbers")));
        }
        let mut numbers = default;
        for (number, item) in numbers.iter_mut().zip(&items) {
            *number = item.as_number()?;
        }
        Ok(numbers)
    }

    /// A member as true or false.
    pub(super) fn flag(&self, key: &str) -> Result<bool, Fault> {
        let Some(json) = self.member(key) else { return Ok(false) };
        json.value.as_bool().ok_or_else(|| json.expected("true or false"))
    }

    /// A member as text.
    pub(super) fn text(&self, key: &str) -> Result<Option<&'a str>, Fault> {
        let Some(json) = self.member(key) else { return Ok(None) };
        json.value.as_str().map(Some).ok_or_else(|| json.expected("text"))
    }

    /// A member as text that names something: of no weight when it is wrong.
    pub(super) fn name(&self) -> Option<&'a str> {
        self.value.get("name").and_then(Value::as_str)
    }
}

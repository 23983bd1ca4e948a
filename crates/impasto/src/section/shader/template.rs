//! Parts of a shader as text: what of a part is wanted, and which of its items a function needs.
//!
//! A part is a file of WGSL in a plain style: every name's type is written out, conditions stand in parentheses, a
//! constant is one line, and other items end with a brace in the first column. A line that ends with `//? tear & !apart | solid`
//! is there only if this holds, `|` being the weaker; so is the text of `[[keep|, site: Site]]`.

/// A structure, constant or function, with the comment above it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Item {
    pub(super) name: String,
    /// Ends with a line feed.
    pub(super) text: String,
}

/// What stands for itself in a text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Token<'a> {
    Word(&'a str),
    Comment(&'a str),
    Space(&'a str),
    /// Numbers, and signs one by one.
    Other(&'a str),
}

impl<'a> Token<'a> {
    pub(super) fn text(self) -> &'a str {
        match self {
            Self::Word(t) | Self::Comment(t) | Self::Space(t) | Self::Other(t) => t,
        }
    }
}

/// Cuts a text into tokens, without losing any of it.
pub(super) fn tokens<'a>(mut text: &'a str) -> Vec<Token<'a>> {
    let mut tokens = Vec::new();
    while let Some(first) = text.chars().next() {
        let run = |of: fn(char) -> bool| text.find(|c| !of(c)).unwrap_or(text.len());
        let (length, make): (usize, fn(&'a str) -> Token<'a>) = if text.starts_with("//") {
            (text.find('\n').unwrap_or(text.len()), Token::Comment)
        } else if first.is_ascii_alphabetic() {
            (run(|c| c.is_ascii_alphanumeric() || c == '_'), Token::Word)
        } else if first.is_ascii_digit() {
            (number_length(text), Token::Other)
        } else if first.is_whitespace() {
            (run(char::is_whitespace), Token::Space)
        } else {
            (first.len_utf8(), Token::Other)
        };
        let (token, rest) = text.split_at(length);
        tokens.push(make(token));
        text = rest;
    }
    tokens
}

/// How long the number is that a text begins with: `0x7feb352du`, `1.0`, `2e-6`.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let is_exponent_sign =
        |i: usize| matches!(bytes[i], b'-' | b'+') && bytes[i - 1] == b'e' && !text.starts_with("0x");
    (1..bytes.len())
        .find(|&i| !(bytes[i].is_ascii_alphanumeric() || bytes[i] == b'.' || is_exponent_sign(i)))
        .unwrap_or(bytes.len())
}

/// The lines of a part that are wanted: those whose words are among `flags`, and not among them where a `!` stands before.
pub(super) fn wanted(part: &str, flags: &[&str]) -> String {
    let is_set = |word: &str| {
        let word = word.trim();
        word.strip_prefix('!').map_or_else(|| flags.contains(&word), |word| !flags.contains(&word))
    };
    let holds = |condition: &str| condition.split('|').any(|all| all.split('&').all(is_set));
    let mut text = String::new();
    for line in part.lines() {
        let (line, condition) = line.split_once("//?").map_or((line, None), |(line, c)| (line.trim_end(), Some(c)));
        if condition.is_some_and(|c| !holds(c)) {
            continue;
        }
        let mut rest = line;
        while let Some((before, after)) = rest.split_once("[[") {
            let (condition, after) = after.split_once('|').expect("a condition within [[ ]]");
            let (inner, after) = after.split_once("]]").expect("[[ ]] ends in its line");
            text.push_str(before);
            if holds(condition) {
                text.push_str(inner);
            }
            rest = after;
        }
        text.push_str(rest);
        text.push('\n');
    }
    text
}

/// The items of a part. A comment that an empty line follows belongs to none of them and is left out.
pub(super) fn items(part: &str) -> Vec<Item> {
    let mut items = Vec::new();
    let (mut text, mut name) = (String::new(), None);
    for line in part.lines() {
        if line.is_empty() && name.is_none() {
            text.clear();
            continue;
        }
        let mut words = line.split(|c: char| !(c.is_alphanumeric() || c == '_'));
        if name.is_none() && matches!(words.next(), Some("fn" | "struct" | "const")) {
            name = words.next().map(str::to_owned);
        }
        text.push_str(line);
        text.push('\n');
        if name.is_some() && (line == "}" || line.starts_with("const")) {
            items.push(Item { name: name.take().unwrap_or_default(), text: std::mem::take(&mut text) });
        }
    }
    assert!(name.is_none(), "a part ends within {name:?}");
    items
}

/// Parts that see each other's items, and how their names begin in what comes out.
#[derive(Clone, Debug, Default)]
pub(super) struct Scope {
    /// Empty, or words with an underscore after each.
    pub(super) prefix: String,
    pub(super) items: Vec<Item>,
    /// Words that mean an item of another scope: word, scope and the item's name there.
    pub(super) links: Vec<(String, usize, String)>,
}

/// The scope whose items all others see.
pub(super) const SHARED: usize = 0;

/// An item by scope and place in it.
pub(super) type Key = (usize, usize);

/// Looks up what a word means in a scope.
fn item_of(scopes: &[Scope], scope: usize, word: &str) -> Option<Key> {
    let place = |s: usize, word: &str| scopes[s].items.iter().position(|item| item.name == word).map(|i| (s, i));
    let linked = || scopes[scope].links.iter().find(|(w, ..)| w == word).and_then(|(_, s, name)| place(*s, name));
    place(scope, word).or_else(linked).or_else(|| place(SHARED, word))
}

/// These items and all that they need, each after those it uses, with their final names.
pub(super) fn linked(scopes: &[Scope], scope: usize, roots: &[&str]) -> Vec<(Key, Item)> {
    let mut order = Vec::new();
    for root in roots {
        visit(scopes, item_of(scopes, scope, root).expect("the root is an item"), &mut order);
    }
    let items: Vec<_> = order.iter().map(|&key| (key, renamed(scopes, key))).collect();
    let mut names: Vec<&str> = items.iter().map(|(_, item)| item.name.as_str()).collect();
    names.sort_unstable();
    assert!(names.is_sorted_by(|a, b| a < b), "two items have the same final name");
    items
}

/// Depth first; no item uses itself, so this ends.
fn visit(scopes: &[Scope], key: Key, order: &mut Vec<Key>) {
    if order.contains(&key) {
        return;
    }
    let item = &scopes[key.0].items[key.1];
    for used in uses(scopes, key, &item.text).into_iter().flatten() {
        if used != key {
            visit(scopes, used, order);
        }
    }
    order.push(key);
}

/// For each token the item it names. What follows a dot is a member.
fn uses(scopes: &[Scope], key: Key, text: &str) -> Vec<Option<Key>> {
    let mut is_member = false;
    let meaning = |token: Token| {
        let found = match token {
            Token::Word(word) if !is_member => item_of(scopes, key.0, word),
            _ => None,
        };
        is_member = token == Token::Other(".");
        found
    };
    tokens(text).into_iter().map(meaning).collect()
}

fn renamed(scopes: &[Scope], key: Key) -> Item {
    let item = &scopes[key.0].items[key.1];
    let final_name = |(s, i): Key| prefixed(&scopes[s].prefix, &scopes[s].items[i].name);
    let parts = tokens(&item.text).into_iter().zip(uses(scopes, key, &item.text));
    let text = parts.map(|(token, used)| used.map_or_else(|| token.text().to_owned(), final_name)).collect();
    Item { name: final_name(key), text }
}

/// `impasto_`, a scope's prefix and a name, in the name's own case.
fn prefixed(prefix: &str, name: &str) -> String {
    let words = format!("impasto_{prefix}");
    let is_upper = |c: char| c.is_ascii_uppercase();
    if name.chars().all(|c| is_upper(c) || c == '_' || c.is_ascii_digit()) {
        words.to_uppercase() + name
    } else if name.starts_with(is_upper) {
        let capital = |w: &str| w[..1].to_uppercase() + &w[1..];
        words.split('_').filter(|w| !w.is_empty()).map(capital).collect::<String>() + name
    } else {
        words + name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_lose_nothing_and_numbers_stay_whole() {
        let text = "let x: f32 = 2e-6 * (a.b - 0x7feb352du); // so\n\tfoo(1.5)";
        let tokens = tokens(text);
        assert_eq!(tokens.iter().map(|t| t.text()).collect::<String>(), text);
        for whole in [Token::Other("2e-6"), Token::Other("0x7feb352du"), Token::Other("1.5"), Token::Comment("// so")] {
            assert!(tokens.contains(&whole), "{whole:?}");
        }
    }

    #[test]
    fn lines_and_parts_of_lines_come_by_their_words() {
        let part = "a\nb //? x\nc //? !x & y\nd[[y|, e]][[!y|, f]]\n";
        assert_eq!(wanted(part, &["x"]), "a\nb\nd, f\n");
        assert_eq!(wanted(part, &["y"]), "a\nc\nd, e\n");
    }

    #[test]
    fn only_what_is_used_comes_out_and_before_its_use() {
        let part =
            "// A part.\n\nfn c() {\n    a(x.b);\n}\n\nfn b() {\n}\n\n// Of a.\nfn a(x: Box) {\n}\n\nstruct Box {\n}\n";
        let scopes = [Scope { prefix: "fine_".into(), items: items(part), links: vec![] }];
        let linked = linked(&scopes, 0, &["c"]);
        let linked: Vec<Item> = linked.into_iter().map(|(_, item)| item).collect();
        let names: Vec<&str> = linked.iter().map(|i| i.name.as_str()).collect();
        assert_eq!(names, ["ImpastoFineBox", "impasto_fine_a", "impasto_fine_c"]);
        assert_eq!(linked[1].text, "// Of a.\nfn impasto_fine_a(x: ImpastoFineBox) {\n}\n");
        assert_eq!(linked[2].text, "fn impasto_fine_c() {\n    impasto_fine_a(x.b);\n}\n");
    }
}

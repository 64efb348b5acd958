//! Holds the table of rooms in ARCHITECTURE.md against the code's own paths.
//!
//! What is read are tokens, not syntax: every `crate::`, `calibstab::` and `super::` path, wherever it stands, grouped imports
//! spelled out. What would hide a path from such a reading (another name for the crate, a file included by its path) is
//! refused.

// Helpers of tests, which the allowance for tests in clippy.toml does not reach.
#![allow(clippy::unwrap_used)]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// With fewer paths between rooms than this the test has gone blind; the first release has twice as many.
const LEAST_PATHS: usize = 60;

/// Room to the rooms that it may use.
type Table = BTreeMap<String, BTreeSet<String>>;

#[test]
fn rooms_use_only_the_rooms_that_the_table_allows() {
    let table = table(&read(&root().join("ARCHITECTURE.md")));
    let mut checked = 0;
    let mut faults = Vec::new();
    for file in rust_files(&root().join("src")) {
        let place = file.strip_prefix(root()).unwrap().display().to_string();
        let found = check(&module_of(&file), &read(&file), &table);
        checked += found.checked;
        faults.extend(found.faults.iter().map(|(line, fault)| format!("{place}:{line}: {fault}")));
    }
    assert!(faults.is_empty(), "\n{}\n", faults.join("\n"));
    assert!(checked >= LEAST_PATHS, "only {checked} paths between rooms were found");
}

#[test]
fn every_room_is_a_row_and_every_row_a_room() {
    let table = table(&read(&root().join("ARCHITECTURE.md")));
    let (mut rooms, mut files) = (BTreeSet::new(), BTreeSet::new());
    for entry in fs::read_dir(root().join("src")).unwrap() {
        let entry = entry.unwrap();
        let name = entry.file_name().into_string().unwrap();
        let kind = if entry.file_type().unwrap().is_dir() { &mut rooms } else { &mut files };
        kind.insert(name);
    }
    assert_eq!(rooms, table.keys().cloned().collect());
    assert_eq!(files, set(&["lib.rs", "main.rs"]), "a file beside the rooms belongs to none");
}

#[test]
fn no_room_uses_itself_by_way_of_others() {
    let mut left = table(&read(&root().join("ARCHITECTURE.md")));
    while !left.is_empty() {
        let before = left.len();
        let rooms: BTreeSet<String> = left.keys().cloned().collect();
        left.retain(|_, uses| !uses.is_disjoint(&rooms));
        assert!(left.len() < before, "the arrows go round in a circle: {left:?}");
    }
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn read(file: &Path) -> String {
    fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

fn set(names: &[&str]) -> BTreeSet<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

/// The rows of the table whose head is `| room | owns | may use |`.
fn table(page: &str) -> Table {
    let rows = page.lines().skip_while(|line| *line != "| room | owns | may use |").skip(2);
    let rows: Vec<[String; 2]> = rows
        .take_while(|line| line.starts_with('|'))
        .map(|row| {
            let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
            let [room, _, uses] = cells[..] else { panic!("not three cells: {row}") };
            [room.trim_matches('`').to_owned(), uses.to_owned()]
        })
        .collect();
    assert!(!rows.is_empty(), "ARCHITECTURE.md has no table of rooms");
    let all: BTreeSet<String> = rows.iter().map(|[room, _]| room.clone()).collect();
    assert_eq!(all.len(), rows.len(), "a room stands in two rows");
    let allowed = |room: &str, uses: &str| match uses {
        "-" => BTreeSet::new(),
        "all" => all.iter().filter(|other| *other != room).cloned().collect(),
        some => some.split(", ").map(str::to_owned).collect(),
    };
    let table: Table =
        rows.iter().map(|[room, uses]| (room.clone(), allowed(room, uses))).collect();
    for (room, uses) in &table {
        assert!(uses.is_subset(&all), "{room} may use what is no room: {uses:?}");
    }
    table
}

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(rust_files(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    files.sort();
    files
}

/// Where a file stands: the module path of a library file, or the program.
#[derive(Debug, Clone, PartialEq)]
enum Place {
    Program,
    Library(Vec<String>),
}

fn module_of(file: &Path) -> Place {
    let within = file.strip_prefix(root().join("src")).unwrap().with_extension("");
    let mut path: Vec<String> =
        within.iter().map(|part| part.to_str().unwrap().to_owned()).collect();
    match path.last().map(String::as_str) {
        Some("main") if path.len() == 1 => return Place::Program,
        Some("lib") if path.len() == 1 => drop(path.pop()),
        Some("mod") => drop(path.pop()),
        _ => {}
    }
    Place::Library(path)
}

/// What a file was found to do: paths from room to room, and the lines of those that it must not have.
#[derive(Debug, Default)]
struct Found {
    checked: usize,
    faults: Vec<(usize, String)>,
}

fn check(place: &Place, source: &str, table: &Table) -> Found {
    let tokens = tokens(source);
    let mut modules = match place {
        Place::Program => Vec::new(),
        Place::Library(path) => path.clone(),
    };
    let (room, allowed) = match (place, modules.first()) {
        (Place::Program, _) => ("main.rs", set(&["cli"])),
        (Place::Library(_), None) => ("lib.rs", table.keys().cloned().collect()),
        (Place::Library(_), Some(room)) => (room.as_str(), table[room].clone()),
    };
    let room = room.to_owned();
    let mut found = Found::default();
    let mut inline_modules = Vec::new();
    let mut depth = 0;
    for at in 0..tokens.len() {
        match tokens[at].text.as_str() {
            "{" => {
                depth += 1;
                if back(&tokens, at, 2) == "mod" {
                    inline_modules.push(depth);
                    modules.push(back(&tokens, at, 1).to_owned());
                }
            }
            "}" => {
                if inline_modules.last() == Some(&depth) {
                    inline_modules.pop();
                    modules.pop();
                }
                depth -= 1;
            }
            "crate" | "calibstab" if ahead(&tokens, at, 1) == "::" => {
                for (line, path) in paths(&tokens, at + 2) {
                    if path[0] != room {
                        found.checked += 1;
                    }
                    if path[0] != room && !allowed.contains(&path[0]) {
                        let fault = format!("{room} must not use `{}`", path.join("::"));
                        found.faults.push((line, fault));
                    }
                }
            }
            "super" if back(&tokens, at, 1) != "::" || back(&tokens, at, 2) == "self" => {
                for (line, path) in paths(&tokens, at) {
                    let climbs = path.iter().take_while(|name| *name == "super").count();
                    if climbs >= modules.len() {
                        let fault = format!("`{}` leaves {room}: say crate::", path.join("::"));
                        found.faults.push((line, fault));
                    }
                }
            }
            _ => found.faults.extend(disguise(&tokens, at).map(|what| (tokens[at].line, what))),
        }
    }
    found
}

/// What would hide a path from a reader of tokens.
fn disguise(tokens: &[Token], at: usize) -> Option<String> {
    let (before, after) = (back(tokens, at, 1), ahead(tokens, at, 1));
    match tokens[at].text.as_str() {
        "crate" if before == "extern" => {
            Some("`extern crate` gives a crate another name".to_owned())
        }
        // `pub(crate)` names no path.
        "crate" if before == "(" && after == ")" => None,
        "crate" => Some("`crate` by itself would be another name for it".to_owned()),
        "calibstab" if before == "use" || after == "as" => {
            Some("`calibstab` by itself would be another name for it".to_owned())
        }
        "path" if before == "[" && back(tokens, at, 2) == "#" => {
            Some("`#[path]` takes a file from anywhere".to_owned())
        }
        "include" if after == "!" => Some("`include!` takes a file from anywhere".to_owned()),
        _ => None,
    }
}

/// The token so many before this one; empty before the first.
fn back(tokens: &[Token], at: usize, count: usize) -> &str {
    at.checked_sub(count).map_or("", |index| &tokens[index].text)
}

/// The token so many after this one; empty after the last.
fn ahead(tokens: &[Token], at: usize, count: usize) -> &str {
    tokens.get(at + count).map_or("", |token| &token.text)
}

/// The paths that start at a token, `a::{b, c::d}` spelled out, each with its line.
fn paths(tokens: &[Token], start: usize) -> Vec<(usize, Vec<String>)> {
    let mut found = Vec::new();
    follow(tokens, start, &[], &mut found);
    found
}

/// Reads one branch of a path and returns where it ends.
fn follow(
    tokens: &[Token],
    mut at: usize,
    prefix: &[String],
    found: &mut Vec<(usize, Vec<String>)>,
) -> usize {
    let mut path = prefix.to_vec();
    loop {
        let Some(token) = tokens.get(at) else { return at };
        if token.text == "{" {
            at += 1;
            while tokens.get(at).is_some_and(|token| token.text != "}") {
                at = follow(tokens, at, &path, found);
                // Past `as name` to the next branch.
                while tokens.get(at).is_some_and(|t| t.text != "," && t.text != "}") {
                    at += 1;
                }
                if tokens.get(at).is_some_and(|token| token.text == ",") {
                    at += 1;
                }
            }
            return at + 1;
        }
        path.push(token.text.clone());
        if tokens.get(at + 1).is_some_and(|token| token.text == "::") {
            at += 2;
        } else {
            found.push((token.line, path));
            return at + 1;
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
struct Token {
    text: String,
    line: usize,
}

/// Words, `::` and single signs; comments, strings and characters left out.
fn tokens(source: &str) -> Vec<Token> {
    let chars: Vec<char> = source.chars().collect();
    let starts = |at: usize, text: &str| {
        text.chars().enumerate().all(|(i, c)| chars.get(at + i) == Some(&c))
    };
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut found = Vec::new();
    let (mut at, mut line) = (0, 1);
    while at < chars.len() {
        let start = at;
        if starts(at, "//") {
            at += chars[at..].iter().take_while(|c| **c != '\n').count();
        } else if starts(at, "/*") {
            at = after_block_comment(&chars, at);
        } else if let Some(end) = after_string(&chars, at) {
            at = end;
        } else if is_word(chars[at]) {
            at += chars[at..].iter().take_while(|c| is_word(**c)).count();
            found.push(Token { text: chars[start..at].iter().collect(), line });
        } else if starts(at, "::") {
            at += 2;
            found.push(Token { text: "::".to_owned(), line });
        } else {
            at += 1;
            if !chars[start].is_whitespace() {
                found.push(Token { text: chars[start].to_string(), line });
            }
        }
        line += chars[start..at].iter().filter(|c| **c == '\n').count();
    }
    found
}

fn after_block_comment(chars: &[char], mut at: usize) -> usize {
    let mut depth = 0;
    while at < chars.len() {
        match (chars[at], chars.get(at + 1)) {
            ('/', Some('*')) => (depth, at) = (depth + 1, at + 2),
            ('*', Some('/')) => (depth, at) = (depth - 1, at + 2),
            _ => at += 1,
        }
        if depth == 0 {
            break;
        }
    }
    at
}

/// Past the string or character that starts here, if one does: "..", b"..", c"..", r#".."#, '.' but not the lifetime 'a.
fn after_string(chars: &[char], start: usize) -> Option<usize> {
    let get = |at: usize| chars.get(at).copied().unwrap_or('\0');
    let mut at = start;
    // A prefix, unless it is the end of a word.
    if start == 0 || !(get(start - 1).is_alphanumeric() || get(start - 1) == '_') {
        at += usize::from(matches!(get(at), 'b' | 'c'));
        let hashes = chars[at..].iter().skip(1).take_while(|c| **c == '#').count();
        if get(at) == 'r' && get(at + 1 + hashes) == '"' {
            let end: Vec<char> =
                std::iter::once('"').chain(std::iter::repeat_n('#', hashes)).collect();
            let body = at + 2 + hashes;
            let length = chars[body..].windows(end.len()).position(|window| window == end);
            return Some(length.map_or(chars.len(), |length| body + length + end.len()));
        }
    }
    let quote = get(at);
    let is_char = quote == '\'' && (get(at + 1) == '\\' || get(at + 2) == '\'');
    if quote != '"' && !is_char {
        return None;
    }
    at += 1;
    while at < chars.len() && chars[at] != quote {
        at += 1 + usize::from(chars[at] == '\\');
    }
    Some(at + 1)
}

mod planted {
    //! The test above would see each of these.

    use super::*;

    fn small_table() -> Table {
        table(
            "| room | owns | may use |\n| - | - | - |\n| `a` | x | - |\n| `b` | x | a |\n| `cli` | x | all |\n",
        )
    }

    fn faults(place: &[&str], source: &str) -> Vec<(usize, String)> {
        let place = Place::Library(place.iter().map(|part| (*part).to_owned()).collect());
        check(&place, source, &small_table()).faults
    }

    #[test]
    fn a_path_to_a_room_that_is_not_allowed_is_seen_wherever_it_stands() {
        for source in [
            "use crate::b::Thing;",
            "use crate::b;",
            "use crate::{b as c, a};",
            "use crate::{a, b::c};",
            "use crate::{\na::{x, y}, b::{c, d}};",
            "fn f() { crate::b::g() }",
            "fn f(x: &'static crate::b::X<'a>) {}",
            "pub(in crate::b) fn f() {}",
            "use calibstab::b;",
            "use ::calibstab::b;",
            "macro_rules! m { () => { $crate::b::g() } }",
            "use crate::*;",
            "use crate::b::*;",
            "use crate::{self as all};",
            "use crate as all;",
            "use calibstab as all;",
            "extern crate self as all;",
            "let s = \"\\\"\"; let c = '\"'; crate::b::g(); // \"",
            "/* /* */ */ crate::b::g()",
            "let r = r#\"\"\"#; crate::b::g()",
            "#[path = \"../b/x.rs\"] mod x;",
            "include!(\"../b/x.rs\");",
        ] {
            assert!(!faults(&["a", "inner"], source).is_empty(), "unseen: {source}");
        }
    }

    #[test]
    fn super_must_not_leave_the_room() {
        for (place, source) in [
            (&["a"][..], "use super::b;"),
            (&["a", "x"], "use super::super::b::Thing;"),
            (&["a", "x"], "use super::{y, super::b};"),
            (&["a", "x"], "use self::super::super::b;"),
            (&["a", "x"], "mod tests { use super::super::super::b; }"),
            (&["a"], "mod tests { mod more {} use super::super::b; }"),
        ] {
            assert_eq!(faults(place, source).len(), 1, "{source}");
        }
        for (place, source) in [
            (&["a"][..], "mod tests { use super::*; }"),
            (&["a", "x"], "use super::{y, z::w}; mod tests { use super::super::y; }"),
            (&["a", "x"], "pub(super) fn f() { self::super::y() }"),
        ] {
            assert_eq!(faults(place, source), [], "{source}");
        }
    }

    #[test]
    fn what_is_allowed_or_no_path_is_no_fault() {
        for source in [
            "use crate::a::{Thing, other::*};",
            "use crate::{a, b::own};",
            "pub(crate) fn f() { crate::b::g() }",
            "// crate::cli::run\n/// [crate::cli]\nfn f() {}",
            "let s = \"crate::cli\"; let r = r\"crate::cli\"; let b = br##\"\"# crate::cli\"##;",
            "let calibstab = 1; f(calibstab);",
            "let include = path;",
        ] {
            assert_eq!(faults(&["b"], source), [], "{source}");
        }
        assert_eq!(faults(&["cli"], "use crate::{a, b};"), []);
    }

    #[test]
    fn the_program_uses_the_command_line_and_nothing_else() {
        let faults = |source| check(&Place::Program, source, &small_table()).faults;
        assert_eq!(faults("fn main() { calibstab::cli::run() }"), []);
        assert_eq!(faults("use calibstab::b;").len(), 1);
        assert_eq!(faults("use calibstab::{cli, a};").len(), 1);
    }

    #[test]
    fn a_fault_has_its_line_and_its_path() {
        let source = "//! Head.\n\nuse crate::{\n    a::Thing,\n    b::Other,\n};\n";
        assert_eq!(faults(&["a"], source), [(5, "a must not use `b::Other`".to_owned())]);
    }

    #[test]
    fn paths_are_counted() {
        let place = Place::Library(vec!["b".to_owned()]);
        let source = "use crate::a::{X, Y}; use crate::b::Z; use super::W;";
        assert_eq!(check(&place, source, &small_table()).checked, 2);
    }
}

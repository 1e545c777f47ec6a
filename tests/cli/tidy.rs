//! The style of docs/design.md, as far as reading the source can tell. A line that breaks a rule is named with its remedy.

use std::fs;
use std::path::{Path, PathBuf};

/// Where source lives.
const ROOTS: [&str; 4] = ["src", "partition", "io", "tests"];
/// Physics: knows neither ranks nor iteration orders that change from run to run.
const PHYSICS: [&str; 7] = ["src/law", "src/bodies", "src/dem", "src/mpm", "src/fem", "src/rve", "src/couple"];
/// The one door to inexact mathematics.
const MATH: &str = "src/base/math.rs";
/// Each of these files argues for its `unsafe`.
const UNSAFE: [&str; 6] = [
    "io/src/h5/chunks.rs",
    "partition/src/transport/mpi.rs",
    "src/base/lane/mod.rs",
    "src/base/lane/x86.rs",
    "src/base/numbers.rs",
    "src/base/zeroed.rs",
];
const LINES_MAX: usize = 700;
/// Functions of the C library, as methods of a float; `log` is left to clippy, since programs keep logs.
const INEXACT: [&str; 21] = [
    "sin", "cos", "tan", "sin_cos", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "exp2", "exp_m1",
    "ln", "ln_1p", "log2", "log10", "powf", "hypot", "cbrt",
];

/// The rooms of `src/`, from the ground up: each may import from those before it.
const ROOMS: [&str; 20] = [
    "base", "law", "bodies", "dem", "mpm", "fem", "rve", "couple", "job", "domain", "store", "prepare", "adapt",
    "observe", "run", "analysis", "bench", "plot", "export", "cli",
];

struct Source {
    /// From the root of the project, with forward slashes.
    path: String,
    text: String,
    /// The text with comments and the insides of literals blanked, line for line.
    code: String,
}

impl Source {
    fn is_physics(&self) -> bool {
        PHYSICS.iter().any(|folder| self.path.starts_with(&format!("{folder}/")) || self.path == format!("{folder}.rs"))
    }

    /// Panics with every line of code that contains one of the words.
    fn forbid(&self, words: &[&str], remedy: &str) {
        for (number, line) in self.code.lines().enumerate() {
            for word in words {
                let found = contains_word(line, word);
                assert!(!found, "{}:{}: `{word}`: {remedy}", self.path, number + 1);
            }
        }
    }
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn sources() -> Vec<Source> {
    let mut paths = Vec::new();
    for folder in ROOTS {
        collect(&root().join(folder), &mut paths);
    }
    paths.sort();
    assert!(paths.len() > 10, "the source was not found below {}", root().display());
    paths
        .iter()
        .map(|path| {
            let text = fs::read_to_string(path).expect("source is UTF-8");
            let relative = path.strip_prefix(root()).expect("below the root").to_string_lossy().replace('\\', "/");
            Source { path: relative, code: code_of(&text), text }
        })
        .collect()
}

fn collect(folder: &Path, paths: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(folder) else {
        return;
    };
    for entry in entries {
        let path = entry.expect("the folder can be listed").path();
        if path.is_dir() {
            if path.file_name().is_some_and(|name| name != "target") {
                collect(&path, paths);
            }
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            paths.push(path);
        }
    }
}

fn is_word_character(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Whether `word` stands in `line` with no letter, digit or underscore next to it.
fn contains_word(line: &str, word: &str) -> bool {
    line.match_indices(word).any(|(at, _)| {
        let before = line[..at].chars().next_back();
        let after = line[at + word.len()..].chars().next();
        let inside_before = word.starts_with(is_word_character) && before.is_some_and(is_word_character);
        let inside_after = word.ends_with(is_word_character) && after.is_some_and(is_word_character);
        !inside_before && !inside_after
    })
}

/// Blanks comments and the insides of string and character literals; keeps line breaks.
fn code_of(text: &str) -> String {
    let source: Vec<char> = text.chars().collect();
    let mut code = String::with_capacity(text.len());
    let mut at = 0;
    while at < source.len() {
        let end = match literal_end(&source, at) {
            Some(end) => end,
            None => {
                code.push(source[at]);
                at += 1;
                continue;
            }
        };
        code.extend(source[at..end].iter().map(|c| if *c == '\n' { '\n' } else { ' ' }));
        at = end;
    }
    code
}

/// The end of the comment or literal that starts here.
fn literal_end(source: &[char], at: usize) -> Option<usize> {
    let next = source.get(at + 1).copied();
    match source[at] {
        '/' if next == Some('/') => Some(find(source, at, '\n')),
        '/' if next == Some('*') => Some(block_comment_end(source, at)),
        '"' => Some(quoted_end(source, at, '"')),
        'r' if matches!(next, Some('"' | '#')) && !follows_word(source, at) => raw_string_end(source, at),
        // A lifetime has no closing quote.
        '\'' if next == Some('\\') || source.get(at + 2) == Some(&'\'') => Some(quoted_end(source, at, '\'')),
        _ => None,
    }
}

fn follows_word(source: &[char], at: usize) -> bool {
    // The b of a raw byte string belongs to the literal.
    at > 0 && is_word_character(source[at - 1]) && source[at - 1] != 'b'
}

fn find(source: &[char], from: usize, wanted: char) -> usize {
    (from..source.len()).find(|at| source[*at] == wanted).unwrap_or(source.len())
}

fn block_comment_end(source: &[char], from: usize) -> usize {
    let mut depth = 0;
    let mut at = from;
    while at + 1 < source.len() {
        match (source[at], source[at + 1]) {
            ('/', '*') => depth += 1,
            ('*', '/') => depth -= 1,
            _ => {
                at += 1;
                continue;
            }
        }
        at += 2;
        if depth == 0 {
            return at;
        }
    }
    source.len()
}

fn quoted_end(source: &[char], from: usize, quote: char) -> usize {
    let mut at = from + 1;
    while at < source.len() {
        match source[at] {
            '\\' => at += 2,
            c if c == quote => return at + 1,
            _ => at += 1,
        }
    }
    source.len()
}

fn raw_string_end(source: &[char], from: usize) -> Option<usize> {
    let hashes = source[from + 1..].iter().take_while(|c| **c == '#').count();
    let open = from + 1 + hashes;
    if source.get(open) != Some(&'"') {
        return None;
    }
    let mut at = open + 1;
    while at < source.len() {
        let closes = source[at] == '"' && source[at + 1..].iter().take(hashes).filter(|c| **c == '#').count() == hashes;
        if closes {
            return Some(at + 1 + hashes);
        }
        at += 1;
    }
    Some(source.len())
}

#[test]
fn this_reader_tells_code_from_words() {
    let text =
        "let a = \"unsafe \\\" // x\"; // HashMap\nlet b = 'x'; /* a /* b */ c */ f::<'a>(r#\"dbg! \"# , '\\'');";
    let code = code_of(text);
    assert_eq!(code.lines().count(), 2);
    for word in ["unsafe", "HashMap", "dbg", "x", "c"] {
        assert!(!contains_word(&code, word), "{word} in {code}");
    }
    assert!(code.contains("let b =") && code.contains("f::<'a>("), "{code}");
    assert!(contains_word("unsafe {", "unsafe") && !contains_word("unsafe_code", "unsafe"));
}

#[test]
fn inexact_mathematics_has_one_door() {
    for source in sources() {
        source.forbid(&["mul_add"], "a fused product rounds once and differs between machines; write a * b + c");
        if source.path == MATH || source.path == "tests/cli/tidy.rs" {
            continue;
        }
        for name in INEXACT {
            let forms = [format!(".{name}("), format!("f64::{name}"), format!("f32::{name}")];
            let forms: Vec<&str> = forms.iter().map(String::as_str).collect();
            source.forbid(&forms, "the C library's rounding differs between machines; use crate::base::math");
        }
        source.forbid(&["libm"], "src/base/math.rs is the one door to libm");
    }
}

#[test]
fn physics_iterates_in_one_order() {
    for source in sources().iter().filter(|source| source.is_physics()) {
        source.forbid(&["HashMap", "HashSet"], "their order changes from run to run; use a sorted Vec or a BTreeMap");
    }
}

#[test]
fn physics_does_not_know_ranks() {
    for source in sources().iter().filter(|source| source.is_physics()) {
        source.forbid(&["scree_partition", "Transport", "mpi"], "ranks are the world layer's; pass plain data");
    }
}

#[test]
fn leaf_crates_know_neither_each_other_nor_the_physics() {
    for source in sources() {
        if source.path.starts_with("partition/") {
            source.forbid(&["scree", "scree_io"], "partition is a leaf crate");
        }
        if source.path.starts_with("io/") {
            source.forbid(&["scree", "scree_partition"], "io is a leaf crate");
        }
    }
}

#[test]
fn dimension_lives_in_space() {
    for source in sources() {
        for (number, line) in source.code.lines().enumerate() {
            let twin = line.split(|c| !is_word_character(c)).find(|word| {
                let word = word.to_lowercase();
                word.ends_with("_2d") || word.ends_with("_3d") || word.contains("_2d_") || word.contains("_3d_")
            });
            if let Some(word) = twin {
                panic!("{}:{}: `{word}`: write it once over the Space trait", source.path, number + 1);
            }
        }
    }
}

#[test]
fn nothing_is_left_for_later() {
    let words = [concat!("TO", "DO"), concat!("FIX", "ME"), concat!("XX", "X")];
    for source in sources() {
        source.forbid(&["todo!", "unimplemented!", "dbg!"], "finish it, or leave it out");
        for (number, line) in source.text.lines().enumerate() {
            for word in words {
                let found = contains_word(line, word);
                assert!(!found, "{}:{}: `{word}`: open an issue, or do it now", source.path, number + 1);
            }
        }
    }
}

#[test]
fn files_are_short() {
    for source in sources() {
        let lines = source.text.lines().count();
        assert!(lines <= LINES_MAX, "{}: {lines} lines, at most {LINES_MAX}; part it by purpose", source.path);
    }
}

#[test]
fn unsafe_stays_where_it_is_argued_for() {
    for source in sources() {
        if !UNSAFE.contains(&source.path.as_str()) {
            source.forbid(&["unsafe"], "unsafe lives in the MPI transport, in lanes and in what brings records there, in rows of zero pages, and in calls of HDF5 that its crate has not");
        }
    }
}

/// A file in tests/ that the index does not name would never be compiled.
#[test]
fn the_index_of_tests_is_whole() {
    let index = fs::read_to_string(root().join("tests/main.rs")).expect("tests/main.rs is the index");
    let mut previous = "";
    for line in index.lines().filter(|line| !line.starts_with("#[path")) {
        if line.starts_with("mod ") {
            assert!(previous.starts_with("/// "), "tests/main.rs: `{line}` has no line that says what it claims");
        }
        previous = line;
    }
    let mut files = Vec::new();
    collect(&root().join("tests"), &mut files);
    for path in files {
        let stem = path.file_stem().expect("a file has a name").to_string_lossy();
        assert!(stem == "main" || index.contains(&format!("mod {stem};")), "tests/main.rs does not name {stem}");
    }
}

/// Code with the items that are compiled for tests alone blanked, line for line.
fn without_tests(code: &str) -> String {
    let (mut kept, mut lines) = (String::new(), code.lines());
    while let Some(line) = lines.next() {
        if line.trim() != "#[cfg(test)]" {
            kept.push_str(line);
        } else {
            // `mod tests;` is a line; what has a body ends where its indentation comes back.
            let end = format!("{}}}", &line[..line.len() - line.trim_start().len()]);
            let head = lines.next().unwrap_or_default();
            kept.push('\n');
            if !head.trim_end().ends_with([';', '}']) {
                for inside in lines.by_ref() {
                    kept.push('\n');
                    if inside == end {
                        break;
                    }
                }
            }
        }
        kept.push('\n');
    }
    kept
}

fn is_of_the_program(path: &str) -> bool {
    path.starts_with("src/") && path != "src/build.rs" && !path.contains("/tests")
}

/// Output to people never ends a run: these macros panic where nobody can be told.
#[test]
fn no_macro_that_panics_speaks_to_people() {
    for source in sources().iter().filter(|source| is_of_the_program(&source.path)) {
        for (number, line) in without_tests(&source.code).lines().enumerate() {
            for word in ["eprintln!", "eprint!", "println!", "print!"] {
                let found = line.split(word).count() > 1;
                assert!(
                    !found,
                    "{}:{}: `{word}` panics on a closed stderr; use domain::meter::tell",
                    source.path,
                    number + 1
                );
            }
        }
    }
}

/// What `cargo deny` would say of licences, sources and versions, by deny.toml.
#[test]
fn dependencies_come_from_the_registry_under_licences_that_are_allowed() {
    let deny: toml::Table = fs::read_to_string(root().join("deny.toml")).unwrap().parse().unwrap();
    let allowed: Vec<&str> =
        deny["licenses"]["allow"].as_array().unwrap().iter().filter_map(|name| name.as_str()).collect();
    let output = std::process::Command::new(env!("CARGO"))
        // Of those for other systems nothing has been fetched.
        .args(["metadata", "--locked", "--offline", "--format-version", "1"])
        .args(["--filter-platform", "x86_64-unknown-linux-gnu"])
        .current_dir(root())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    assert!(packages.len() > 50);
    for package in packages {
        let name = package["name"].as_str().unwrap();
        if let Some(source) = package["source"].as_str() {
            assert_eq!(
                source, "registry+https://github.com/rust-lang/crates.io-index",
                "{name} is of another registry"
            );
        }
        // One of those between OR, each of those between AND.
        let licence = package["license"].as_str().unwrap_or("none").replace('/', " OR ");
        let any = |part: &str| part.split(" OR ").any(|one| allowed.contains(&one.trim_matches([' ', '(', ')'])));
        assert!(licence.split(" AND ").all(any), "{name}: {licence}");
        for dependency in package["dependencies"].as_array().unwrap() {
            let is_ours = package["source"].is_null() && dependency["source"].is_string();
            assert!(!is_ours || dependency["req"] != "*", "{name} takes any version of {}", dependency["name"]);
        }
    }
}

/// Rooms that code outside of tests names, by `crate::` or by as many `super` as lead there.
fn rooms_named<'r>(source: &Source, rooms: &[&'r str]) -> Vec<&'r str> {
    let code = without_tests(&source.code);
    let module = source.path.trim_start_matches("src/").trim_end_matches(".rs").trim_end_matches("/mod");
    let root = vec!["super"; module.split('/').count()].join("::") + "::";
    let mut named = Vec::new();
    for (at, found) in code.match_indices("crate::").chain(code.match_indices(root.as_str())) {
        let rest = &code[at + found.len()..];
        let one = |text: &str| -> String { text.chars().take_while(|c| is_word_character(*c)).collect() };
        match rest.strip_prefix('{') {
            None => named.push(one(rest)),
            Some(group) => named.extend(heads(group).into_iter().map(|text| one(text.trim_start()))),
        }
    }
    rooms.iter().copied().filter(|room| named.iter().any(|name| name == room)).collect()
}

/// What stands between the commas of a group of imports, groups within it left whole.
fn heads(group: &str) -> Vec<&str> {
    let (mut depth, mut from, mut heads) = (0, 0, Vec::new());
    for (at, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' | ',' if depth == 0 => {
                heads.push(&group[from..at]);
                from = at + 1;
                if c == '}' {
                    break;
                }
            }
            '}' => depth -= 1,
            _ => {}
        }
    }
    heads
}

#[test]
fn rooms_are_found_where_they_are_named() {
    let source = |path: &str, text: &str| Source { path: path.into(), text: text.into(), code: code_of(text) };
    let named = |path, text| rooms_named(&source(path, text), &ROOMS);
    assert_eq!(named("src/dem/motion.rs", "use crate::{base::ids, job::{Output, run}};"), ["base", "job"]);
    assert_eq!(named("src/dem/motion.rs", "fn f(x: crate::run::Core) {} // crate::cli"), ["run"]);
    assert_eq!(named("src/dem/mod.rs", "use super::domain::World; use super::super::x;"), ["domain"]);
    assert_eq!(named("src/dem/a/b.rs", "use super::super::super::plot; use super::job;"), ["plot"]);
    let with_tests = "#[cfg(test)]\nmod tests;\nuse crate::dem;\n#[cfg(test)]\nmod more {\n    use crate::cli;\n}\nuse crate::run;\n";
    assert_eq!(named("src/law/a.rs", with_tests), ["dem", "run"]);
}

/// Whoever works in a room need know those below it only, and no two of them need each other.
#[test]
fn imports_go_down() {
    let mut upwards = Vec::new();
    for source in sources().iter().filter(|source| is_of_the_program(&source.path)) {
        let Some((room, _)) = source.path.trim_start_matches("src/").split_once('/') else {
            continue;
        };
        let level = ROOMS.iter().position(|other| other == &room);
        let level = level.unwrap_or_else(|| panic!("{}: there is no room {room}; see ROOMS", source.path));
        let above = rooms_named(source, &ROOMS[level + 1..]);
        upwards.extend(above.into_iter().map(|above| (source.path.clone(), above)));
    }
    assert!(upwards.is_empty(), "these import from a room above theirs; move what they need down: {upwards:#?}");
}

/// What a contributor is told of the rooms is what there is.
#[test]
fn every_room_stands_in_the_design() {
    let design = fs::read_to_string(root().join("docs/design.md")).expect("docs/design.md is the design");
    for entry in fs::read_dir(root().join("src")).expect("src/ exists") {
        let path = entry.expect("src/ can be listed").path();
        let room = path.file_name().expect("a room has a name").to_string_lossy().into_owned();
        assert!(!path.is_dir() || design.contains(&format!("`{room}`")), "docs/design.md does not name {room}");
    }
}

//! The pages that people read: links lead somewhere, the contents of the handbook are whole, and the theory names files that exist.

use std::fs;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// As people name it.
fn shown(path: &Path) -> String {
    path.strip_prefix(root()).unwrap_or(path).to_string_lossy().replace('\\', "/")
}

/// Pages below a folder, of which what is built or hidden is none.
fn pages(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("the folder can be listed") {
        let path = entry.expect("the folder can be listed").path();
        let name = path.file_name().expect("a file has a name").to_string_lossy().into_owned();
        if path.is_dir() {
            if name != "target" && !name.starts_with('.') {
                found.extend(pages(&path));
            }
        } else if name.ends_with(".md") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Lines outside of blocks of code, with their numbers.
fn lines(text: &str) -> Vec<(usize, &str)> {
    let mut in_block = false;
    let mut kept = Vec::new();
    for (at, line) in text.lines().enumerate() {
        if line.trim_start().starts_with("```") {
            in_block = !in_block;
        } else if !in_block && !line.starts_with("    ") {
            kept.push((at + 1, line));
        }
    }
    kept
}

/// Where links and pictures lead, with the numbers of their lines. What stands between backticks is code, and may go on in the next line.
fn links(text: &str) -> Vec<(usize, String)> {
    let mut in_code = false;
    let mut found = Vec::new();
    for (number, line) in lines(text) {
        if line.trim().is_empty() {
            in_code = false;
        }
        let mut prose = String::new();
        for (at, piece) in line.split('`').enumerate() {
            in_code ^= at > 0;
            if !in_code {
                prose.push_str(piece);
            }
        }
        for (at, open) in prose.match_indices("](") {
            let rest = &prose[at + open.len()..];
            let target = rest.split(')').next().unwrap_or(rest);
            // A title may stand behind it.
            found.push((number, target.split_whitespace().next().unwrap_or_default().to_string()));
        }
    }
    found
}

/// The anchors of headings, as GitHub and mdBook make them: letters, digits, `-` and `_` in lower case, blanks as `-`, a number behind
/// what has been there before.
fn anchors(text: &str) -> Vec<String> {
    let mut plain: Vec<String> = Vec::new();
    let mut anchors = Vec::new();
    for (_, line) in lines(text) {
        let heading = line.trim_start_matches('#');
        if heading.len() == line.len() || !heading.starts_with(' ') {
            continue;
        }
        let kept = heading.trim().chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        let anchor: String = kept.flat_map(char::to_lowercase).map(|c| if c == ' ' { '-' } else { c }).collect();
        let before = plain.iter().filter(|other| **other == anchor).count();
        anchors.push(if before == 0 { anchor.clone() } else { format!("{anchor}-{before}") });
        plain.push(anchor);
    }
    anchors
}

/// What is wrong with a link of a page, if anything is; what leads out of the repository is not followed.
fn problem(page: &Path, target: &str) -> Option<String> {
    if target.contains("://") || target.starts_with("mailto:") {
        return None;
    }
    let (path, anchor) = target.split_once('#').map_or((target, None), |(path, anchor)| (path, Some(anchor)));
    let file = if path.is_empty() { page.to_path_buf() } else { page.parent()?.join(path) };
    if !file.exists() {
        return Some("there is no such file".to_string());
    }
    let anchor = anchor.filter(|_| file.extension().is_some_and(|extension| extension == "md"))?;
    let there = anchors(&read(&file));
    let is_there = there.iter().any(|other| other == anchor);
    (!is_there).then(|| format!("{} has no such heading; it has {}", shown(&file), there.join(", ")))
}

#[test]
fn this_reader_tells_links_from_code() {
    let text = "# A `b` & c (1)\n[x](y.md#z) `[i](j)` and `code\nthat [k](l) goes on` ![p](q.png \"r\")\n\n```\n[m](n)\n# d\n```\n    [o](s)\n## A b  c 1\n# A `b` & c (1)\n";
    let found: Vec<(usize, String)> = links(text);
    assert_eq!(found, [(2, "y.md#z".to_string()), (3, "q.png".to_string())]);
    assert_eq!(anchors(text), ["a-b--c-1", "a-b--c-1-1", "a-b--c-1-2"]);
}

#[test]
fn every_link_leads_somewhere() {
    let pages = pages(root());
    assert!(pages.len() > 20, "the pages were not found below {}", root().display());
    let mut broken = Vec::new();
    for page in &pages {
        for (number, target) in links(&read(page)) {
            if let Some(problem) = problem(page, &target) {
                broken.push(format!("{}:{number}: ({target}): {problem}", shown(page)));
            }
        }
    }
    assert!(broken.is_empty(), "these links lead nowhere:\n{}", broken.join("\n"));
}

/// mdBook passes over what its contents do not name.
#[test]
fn every_page_stands_in_the_contents() {
    let docs = root().join("docs");
    let contents = docs.join("SUMMARY.md");
    let named: Vec<PathBuf> = links(&read(&contents)).into_iter().map(|(_, target)| docs.join(target)).collect();
    for page in pages(&docs).iter().filter(|page| **page != contents) {
        assert!(named.contains(page), "{} does not stand in docs/SUMMARY.md; add a line for it", shown(page));
    }
}

/// Who looks for an equation is led to the file that holds it.
#[test]
fn the_theory_names_files_that_exist() {
    let theory = read(&root().join("docs/theory.md"));
    let mut named = 0;
    for (number, line) in theory.lines().enumerate() {
        for (at, _) in line.match_indices("src/") {
            let is_of_name = |c: &char| c.is_alphanumeric() || matches!(c, '/' | '_' | '.');
            let name: String = line[at..].chars().take_while(is_of_name).collect();
            if name.ends_with(".rs") {
                assert!(root().join(&name).is_file(), "docs/theory.md:{}: there is no file {name}", number + 1);
                named += 1;
            }
        }
    }
    assert!(named > 60, "docs/theory.md names {named} files");
}

/// The head of `VALIDATION.md` says how many claims are met and missed; a row that is added, or changes its verdict, must be counted.
#[test]
fn claims_are_counted() {
    const VERDICTS: [&str; 4] = ["yes", "**no**", "partly", "shown"];
    let page = fs::read_to_string(root().join("VALIDATION.md")).unwrap();
    let (mut section, mut found) = (String::new(), Vec::<(String, [usize; 4])>::new());
    for line in page.lines() {
        if let Some(title) = line.strip_prefix("## ") {
            section = title.to_owned();
        }
        let cells: Vec<&str> = line.trim_matches('|').rsplit('|').map(str::trim).collect();
        let Some(verdict) = cells.get(1).and_then(|cell| VERDICTS.iter().position(|word| word == cell)) else {
            continue;
        };
        if found.last().is_none_or(|(last, _)| *last != section) {
            found.push((section.clone(), [0; 4]));
        }
        found.last_mut().expect("it has just been made").1[verdict] += 1;
    }
    assert!(found.len() > 5, "{found:?}");
    let mut all = [0; 4];
    for (section, counts) in &found {
        (0..4).for_each(|verdict| all[verdict] += counts[verdict]);
        let [met, missed, partly, shown] = counts;
        let wanted = format!(") | {} | {met} | {missed} | {partly} | {shown} |", counts.iter().sum::<usize>());
        let line = page.lines().find(|line| line.starts_with(&format!("| [{section}]("))).unwrap_or_default();
        assert!(line.ends_with(&wanted), "{section} has {counts:?}, and the head says {line}");
    }
    let [met, missed, partly, shown] = all;
    let wanted = format!(
        "**{} claims: {met} met, {missed} missed, {partly} met in part, {shown} shown",
        all.iter().sum::<usize>()
    );
    assert!(page.contains(&wanted), "the head should say: {wanted}");
}

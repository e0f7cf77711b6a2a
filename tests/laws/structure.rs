//! Modules use only modules that lib.rs lists before them, and files of the library have no dependency cycles.
//!
//! Read off the `use` lines. A file that only re-exports from its own children does not use them; tests inside a file
//! do not count.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Module path ("yarn::response") and text without its tests.
type Files = BTreeMap<String, String>;

/// Rooms that still have circles of files inside, to be taken apart; a room that is clean leaves this list.
const STILL_IN_CIRCLES: [&str; 0] = [];

fn read(folder: &Path, module: &str, files: &mut Files) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let inside = |name: &str| match module {
            "" => name.to_owned(),
            _ => format!("{module}::{name}"),
        };
        if path.is_dir() {
            read(&path, &inside(&stem), files);
        } else if path.extension().is_some_and(|extension| extension == "rs")
            && !["lib", "main"].contains(&stem.as_str())
        {
            let text = fs::read_to_string(&path).unwrap();
            let text = text.split("#[cfg(test)]\nmod tests").next().unwrap().to_owned();
            let module = if stem == "mod" {
                module.to_owned()
            } else {
                inside(&stem)
            };
            files.insert(module, text);
        }
    }
}

fn library() -> Files {
    let mut files = Files::new();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    read(&source, "", &mut files);
    // The binary's own modules are no part of the library.
    files.retain(|module, _| module != "cli" && !module.starts_with("cli::"));
    files
}

fn room(module: &str) -> &str {
    module.split("::").next().unwrap()
}

/// One thing that a `use` line names: whether it is re-exported, the path before it, its name.
struct Import {
    public: bool,
    path: Vec<String>,
    name: String,
}

fn imports(text: &str) -> Vec<Import> {
    let mut all = Vec::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        let Some(start) = ["use ", "pub use ", "pub(super) use ", "pub(crate) use "]
            .iter()
            .find(|s| line.starts_with(**s))
        else {
            continue;
        };
        let mut statement = line[start.len()..].to_owned();
        while !statement.ends_with(';') {
            statement += lines.next().unwrap().trim();
        }
        let mut found = Vec::new();
        expand(statement.trim_end_matches(';'), &[], &mut found);
        all.extend(found.into_iter().map(|(path, name)| Import {
            public: start.starts_with("pub"),
            path,
            name,
        }));
    }
    all
}

/// Every name of a `use` tree with the path before it.
fn expand(tree: &str, before: &[String], found: &mut Vec<(Vec<String>, String)>) {
    let tree = tree.trim();
    let parts = |path: &str| {
        path.split("::")
            .filter(|p| !p.is_empty())
            .map(|p| p.trim().to_owned())
            .collect::<Vec<_>>()
    };
    if let Some(open) = tree.find('{') {
        let before = [before, &parts(&tree[..open])].concat();
        let inner = &tree[open + 1..tree.rfind('}').unwrap()];
        let (mut depth, mut from) = (0, 0);
        for (at, letter) in inner.char_indices() {
            match letter {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    expand(&inner[from..at], &before, found);
                    from = at + 1;
                }
                _ => {}
            }
        }
        if !inner[from..].trim().is_empty() {
            expand(&inner[from..], &before, found);
        }
    } else {
        let named = tree.split(" as ").next().unwrap();
        let mut path = [before, &parts(named)].concat();
        let mut name = path.pop().unwrap();
        if name == "self" {
            name = path.pop().unwrap();
        }
        found.push((path, name));
    }
}

/// The module that a path leads to from inside `module`; none outside the library.
fn target(files: &Files, module: &str, path: &[String]) -> Option<String> {
    let mut at: Vec<&str> = module.split("::").collect();
    let mut rest = path;
    match path.first().map(String::as_str) {
        Some("crate") => {
            at.clear();
            rest = &path[1..];
        }
        Some("self") => rest = &path[1..],
        Some("super") => {
            while rest.first().is_some_and(|part| part == "super") {
                at.pop();
                rest = &rest[1..];
            }
        }
        Some(first) if !files.contains_key(&format!("{module}::{first}")) => return None,
        _ => {}
    }
    at.extend(rest.iter().map(String::as_str));
    Some(at.join("::"))
}

/// The file in which a name is defined that `module` offers.
fn owner(files: &Files, module: &str, name: &str, depth: usize) -> Option<String> {
    let child = if module.is_empty() {
        name.to_owned()
    } else {
        format!("{module}::{name}")
    };
    let text = files.get(module);
    let defines = |text: &String| {
        let kinds = [
            "fn",
            "struct",
            "enum",
            "trait",
            "type",
            "const",
            "static",
            "unsafe fn",
            "const fn",
        ];
        text.lines().any(|line| {
            let line = line
                .trim_start_matches("pub(super) ")
                .trim_start_matches("pub(crate) ")
                .trim_start_matches("pub ");
            kinds.iter().any(|kind| {
                line.strip_prefix(kind)
                    .and_then(|rest| rest.strip_prefix(' '))
                    .and_then(|rest| rest.strip_prefix(name))
                    .is_some_and(|rest| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_'))
            })
        })
    };
    if text.is_some_and(defines) {
        return Some(module.to_owned());
    }
    if files.contains_key(&child) {
        return Some(child);
    }
    if depth == 0 {
        return None;
    }
    let exported = imports(text?)
        .into_iter()
        .filter(|import| import.public && import.name == name);
    exported
        .filter_map(|import| owner(files, &target(files, module, &import.path)?, &import.name, depth - 1))
        .next()
}

/// Which files each file uses.
fn edges(files: &Files) -> BTreeMap<String, BTreeSet<String>> {
    let mut edges = BTreeMap::new();
    for (module, text) in files {
        let used: &mut BTreeSet<String> = edges.entry(module.clone()).or_default();
        for import in imports(text) {
            let defined = target(files, module, &import.path).and_then(|at| owner(files, &at, &import.name, 4));
            if let Some(file) = defined
                && file != *module
                && !(import.public && file.starts_with(&format!("{module}::")))
            {
                used.insert(file);
            }
        }
    }
    edges
}

/// Files that reach themselves again, with the others on the way.
fn in_circles(edges: &BTreeMap<String, BTreeSet<String>>) -> BTreeSet<String> {
    let reached = |from: &String| {
        let mut seen = BTreeSet::new();
        let mut next: Vec<&String> = edges[from].iter().collect();
        while let Some(file) = next.pop() {
            if seen.insert(file.clone()) {
                next.extend(&edges[file]);
            }
        }
        seen
    };
    edges
        .keys()
        .filter(|file| reached(file).contains(*file))
        .cloned()
        .collect()
}

#[test]
fn files_have_no_dependency_cycles() {
    let circles = in_circles(&edges(&library()));
    let rooms: BTreeSet<&str> = circles.iter().map(|file| room(file)).collect();
    let known = BTreeSet::from(STILL_IN_CIRCLES);
    assert!(rooms == known, "in circles: {circles:#?}; listed: {known:?}");
}

#[test]
fn modules_use_only_modules_listed_before_them() {
    let lib = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs")).unwrap();
    let order: Vec<&str> = lib
        .lines()
        .filter_map(|line| line.strip_prefix("//! - `")?.split('`').next())
        .collect();
    let declared: BTreeSet<&str> = lib
        .lines()
        .filter_map(|line| line.trim_start_matches("pub ").strip_prefix("mod ")?.strip_suffix(';'))
        .collect();
    assert_eq!(
        BTreeSet::from_iter(order.iter().copied()),
        declared,
        "the list of lib.rs"
    );
    let place = |room: &str| order.iter().position(|known| *known == room).unwrap();
    for (module, text) in library() {
        // Paths inside the code count as well as `use` lines; comments do not.
        let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        for used in code.flat_map(|line| line.split("crate::").skip(1).map(str::to_owned).collect::<Vec<_>>()) {
            let used: String = used.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            if declared.contains(used.as_str()) && used != room(&module) {
                assert!(
                    place(&used) < place(room(&module)),
                    "{module} uses {used}, which lib.rs lists below it"
                );
            }
        }
    }
}

/// The check detects a cycle, and accepts a graph without one.
#[test]
fn cycle_is_detected() {
    let text = |uses: &str, defines: &str| format!("{uses}\npub struct {defines};\n");
    let mut files = Files::from([
        (
            "a".to_owned(),
            "mod b;\nmod c;\npub use b::{B, D};\npub use c::C;\n".to_owned(),
        ),
        ("a::b".to_owned(), text("use super::C;", "B") + "pub struct D;\n"),
        ("a::c".to_owned(), text("", "C")),
    ]);
    assert!(in_circles(&edges(&files)).is_empty());
    files.insert("a::c".to_owned(), text("use crate::a::{self, D as E};", "C"));
    assert_eq!(
        in_circles(&edges(&files)),
        BTreeSet::from(["a::b".to_owned(), "a::c".to_owned()])
    );
}

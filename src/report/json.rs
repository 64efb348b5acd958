//! Results as JSON: the one form that holds everything.

use serde::Serialize;

use crate::selection::experiment::Selection;
use crate::stability::{Analysis, Comparison};

/// `analysis.json`.
pub fn analysis_json(analysis: &Analysis) -> serde_json::Result<String> {
    pretty(analysis)
}

/// `comparison.json`.
pub fn comparison_json(comparison: &Comparison) -> serde_json::Result<String> {
    pretty(comparison)
}

/// `selection.json`.
pub fn selection_json(selection: &Selection) -> serde_json::Result<String> {
    pretty(selection)
}

/// The JSON schema of `analysis.json`.
pub fn schema_json() -> serde_json::Result<String> {
    Ok(serde_json::to_string_pretty(&schemars::schema_for!(Analysis))? + "\n")
}

/// The JSON schema of `selection.json`.
pub fn selection_schema_json() -> serde_json::Result<String> {
    Ok(serde_json::to_string_pretty(&schemars::schema_for!(Selection))? + "\n")
}

/// Indented, but with every list of numbers or pairs on one line: a map has thousands.
fn pretty(value: &impl Serialize) -> serde_json::Result<String> {
    let long = serde_json::to_string_pretty(value)?;
    let mut out = String::with_capacity(long.len());
    let mut lines = long.lines();
    while let Some(line) = lines.next() {
        out.push_str(line);
        if line.ends_with('[') {
            let mut rest = lines.clone();
            if let Some(list) = list(&mut rest, 2) {
                out.push_str(&list);
                lines = rest;
            }
        }
        out.push('\n');
    }
    Ok(out)
}

/// What follows an opening bracket up to its closing one, on one line; none where objects or lists nested deeper are in it.
fn list(lines: &mut std::str::Lines, depth: usize) -> Option<String> {
    /// Lists of longer lists are matrices, and read better row by row.
    const PAIR: usize = 2;
    let mut out = String::new();
    let (mut count, mut is_nested) = (0, false);
    loop {
        // A list ends before its text does.
        let line = lines.next()?.trim_start();
        if line.starts_with(']') {
            out.push_str(line);
            return (!is_nested || depth == 2)
                .then_some(out)
                .filter(|_| depth == 2 || count <= PAIR);
        }
        out.push_str(line);
        if line.ends_with('{') {
            return None;
        }
        if line.ends_with('[') {
            is_nested = true;
            out.push_str(&list(lines, depth.checked_sub(1).filter(|depth| *depth > 0)?)?);
        }
        count += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_numbers_and_pairs_stand_on_one_line_and_all_else_below_each_other() {
        let value = serde_json::json!({
            "map": [1.5, null, -2e-9],
            "pairs": [[1, 2], [3, 4]],
            "rows": [[1, 2, 3], [4, 5, 6]],
            "empty": [],
            "names": ["a [", "b, {", "]"],
            "objects": [{ "x": [1, 2] }],
        });
        let text = pretty(&value).unwrap();
        for line in [
            r#""map": [1.5,null,-2e-9],"#,
            r#""pairs": [[1,2],[3,4]],"#,
            "    [1,2,3],",
            r#"  "empty": [],"#,
            r#""names": ["a [","b, {","]"],"#,
            r#"      "x": [1,2]"#,
        ] {
            assert!(text.lines().any(|found| found.ends_with(line)), "{line} in {text}");
        }
        assert_eq!(serde_json::from_str::<serde_json::Value>(&text).unwrap(), value);
    }
}

//! The program: its files, and its messages on errors.

use std::error::Error;
use std::fs;
use std::path::Path;

use assert_cmd::Command;
use assert_cmd::assert::Assert;

/// Runs the program in the root of the repository.
fn clastic_bench(arguments: &[&str]) -> Assert {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    Command::new(env!("CARGO_BIN_EXE_clastic_bench")).current_dir(root).args(arguments).assert()
}

#[test]
fn writes_tables_and_brings_a_page_up_to_date() -> Result<(), Box<dyn Error>> {
    let directory = tempfile::tempdir()?;
    let (out, page) = (directory.path().join("bench"), directory.path().join("page.md"));
    fs::write(&page, "<!-- begin theta.md -->\n<!-- end theta.md -->\n")?;
    let [out_text, page_text] = [&out, &page].map(|path| path.to_str().unwrap_or_default());
    clastic_bench(&["theta", "--quick", "--out", out_text, "--page", page_text]).code(0);
    let table = fs::read_to_string(out.join("theta.csv"))?;
    let mut rows = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = rows.next().ok_or("no header")?;
    let column = |name: &str| header.iter().position(|h| *h == name).ok_or("no such column");
    let (theta, order) = (column("theta")?, column("observed_order")?);
    let last = rows.rfind(|row| row[theta] == "0.5").ok_or("no row")?;
    let order: f64 = last[order].parse()?;
    assert!((order - 2.0).abs() < 0.01, "{order}");
    let page = fs::read_to_string(&page)?;
    let command = "command: `cargo run --release -p clastic_bench -- theta --quick`";
    assert!(page.contains(command), "{page}");
    assert!(page.contains("](bench/theta.svg)"), "{page}");
    assert!(fs::read_to_string(out.join("summary.md"))?.contains("## theta"));

    let missing = ["stages", "--quick", "--scenes", "nowhere", "--out", out_text];
    let refused = clastic_bench(&missing).code(1);
    let said = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
    assert!(said.contains("nowhere"), "{said}");
    Ok(())
}

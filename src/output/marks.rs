//! Marks of a run whose results need care.

use serde_json::Value;

use crate::run::key_results::PEAK_ERROR;

/// Share of capped increments above which a run is marked.
const CAPPED: f64 = 0.01;

/// Marks of a run by its `run.json`: how it ended if not as planned, capped increments above 1 %, stages that ended
/// before their stops, and an estimated error of the peak above 2 %. Empty for a run that can be trusted.
pub fn marks(record: &Value) -> Vec<String> {
    let mut marks = Vec::new();
    match record["outcome"]["status"].as_str() {
        Some("completed" | "collapsed") => {}
        Some(status) => marks.push(status.to_owned()),
        None => marks.push("not run".to_owned()),
    }
    let number = |value: &Value| value.as_f64().unwrap_or(0.0);
    let capped = number(&record["capped_increments"]) / number(&record["increments"]).max(1.0);
    if capped > CAPPED {
        marks.push(format!("{:.0} % of increments capped", 100.0 * capped));
    }
    let stages = record["stages"].as_array().into_iter().flatten();
    let is_cut = |end: &&Value| end["ended_by"] == "all_increments" && !end["stop"].is_null();
    marks.extend(stages.filter(is_cut).map(|end| {
        format!("stage {} ended before its stop", end["stage"].as_str().unwrap_or_default())
    }));
    let error = number(&record["results"]["peak_error_estimate"]);
    if error > PEAK_ERROR {
        marks.push(format!("peak uncertain by about {:.0} %", 100.0 * error));
    }
    marks
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn what_is_not_trustworthy_is_marked() {
        let run = |status: &str, capped: u32, error: f64| {
            json!({ "outcome": { "status": status }, "increments": 100, "capped_increments": capped,
                "results": { "peak_error_estimate": error } })
        };
        assert!(marks(&run("collapsed", 1, 0.01)).is_empty());
        assert_eq!(marks(&run("undecided", 0, 0.0)), ["undecided"]);
        assert_eq!(marks(&run("completed", 2, 0.0)), ["2 % of increments capped"]);
        assert_eq!(marks(&run("completed", 0, 0.05)), ["peak uncertain by about 5 %"]);
        assert_eq!(marks(&Value::Null), ["not run"]);
    }
}

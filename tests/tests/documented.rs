//! What the documents tell a reader to send is sent: the README's lines, and the examples of the OpenAPI document.

use std::time::Duration;

use anyhow::{Context as _, ensure};
use reqwest::{Method, RequestBuilder};
use serde_json::Value;
use tests::TestCell;

const LONG: Duration = Duration::from_secs(30);
const README: &str = include_str!("../../README.md");

/// A `curl` line: as much of it as the README uses.
#[derive(Debug, Default)]
struct Curl {
    url: String,
    body: Option<String>,
    /// Its answer's token goes into the variable `CONTROL`.
    takes_control: bool,
    has_control: bool,
}

/// The `curl` lines of a Markdown text, continued lines joined.
fn curls(markdown: &str) -> Vec<Curl> {
    let joined = markdown.replace("\\\n", " ");
    joined
        .lines()
        .filter_map(|line| {
            let taking = line.strip_prefix("CONTROL=$(curl ");
            let taking = taking.and_then(|line| line.split(" | sed ").next());
            let plain = line.strip_prefix("curl ");
            taking
                .map(|line| (line, true))
                .or(plain.map(|line| (line, false)))
        })
        .map(|(line, takes_control)| {
            let mut curl = Curl {
                takes_control,
                has_control: line.contains("-H \"Control-Token: $CONTROL\""),
                ..Curl::default()
            };
            let mut words = words(line).into_iter();
            while let Some(word) = words.next() {
                match word.as_str() {
                    "-d" => curl.body = words.next(),
                    "-H" | "-X" => drop(words.next()),
                    url if url.starts_with("http://") => url.clone_into(&mut curl.url),
                    _ => {}
                }
            }
            curl
        })
        .collect()
}

/// Words as a shell splits them; single quotes only.
fn words(line: &str) -> Vec<String> {
    let mut words = Vec::new();
    for (index, part) in line.split('\'').enumerate() {
        if index % 2 == 1 {
            words.push(part.to_owned());
        } else {
            words.extend(part.split_whitespace().map(str::to_owned));
        }
    }
    words
}

async fn answer(request: RequestBuilder) -> anyhow::Result<String> {
    let response = request.send().await?;
    let status = response.status();
    let text = response.text().await?;
    ensure!(status.is_success(), "{status}: {text}");
    Ok(text)
}

#[tokio::test]
async fn the_readmes_lines_work_when_they_are_pasted() -> anyhow::Result<()> {
    let mut cell = TestCell::start().await?;
    cell.give_up_control().await?;
    let panel = cell.emulator().panel_address().context("no panel")?;
    let http = reqwest::Client::new();
    let curls = curls(README);
    let moves = curls
        .iter()
        .filter(|curl| curl.body.is_some() && !curl.takes_control)
        .count();
    let mut control = String::new();
    assert_eq!(moves, 2, "{curls:?}");
    for curl in &curls {
        let url = curl
            .url
            .replace("127.0.0.1:8080", &cell.server_address().to_string())
            .replace("127.0.0.1:8081", &panel.to_string());
        let request = match &curl.body {
            Some(body) => http
                .post(&url)
                .header("content-type", "application/json")
                .header("idempotency-key", "a-second-of-the-clock")
                .body(body.clone()),
            None => http.get(&url),
        };
        let request = if curl.has_control {
            request.header("control-token", &control)
        } else {
            request
        };
        let answer = answer(request).await.with_context(|| format!("{curl:?}"))?;
        if curl.takes_control {
            // As the line's `sed` cuts it out.
            let (_, token) = answer.split_once("\"token\":\"").context("no token")?;
            token
                .split('"')
                .next()
                .unwrap_or_default()
                .clone_into(&mut control);
        }
    }
    let state = cell.wait_until_finished(moves, LONG).await?;
    assert!((state.pose.x_mm - 985.0).abs() < 0.01, "{:?}", state.pose);
    cell.shutdown().await
}

#[tokio::test]
async fn the_examples_of_the_openapi_document_work_when_they_are_tried() -> anyhow::Result<()> {
    let mut cell = TestCell::start().await?;
    cell.give_up_control().await?;
    let base = format!("http://{}", cell.server_address());
    let http = reqwest::Client::new();
    let document = answer(http.get(format!("{base}/api/v1/openapi.json"))).await?;
    let document: Value = serde_json::from_str(&document)?;
    // A relative move needs a target to count from.
    let _ = answer(http.post(format!("{base}/fanuc/home"))).await?;
    let paths = document["paths"].as_object().context("no paths")?;
    let mut control = String::new();
    let mut bodies = 0;
    for (path, item) in paths {
        for (method, operation) in item.as_object().context("no operations")? {
            let Some(path) = filled(path, operation) else {
                continue;
            };
            // In a demo there are no tokens, and the set-up of this cell is empty: no mobile robot, no point for a job.
            let absent = ["/api/v1/tokens", "/setup/", "/mobile-robots/", "/jobs"];
            // A stream of events has no end to wait for.
            let answers = &operation["responses"]["200"]["content"];
            if answers.as_object().is_some_and(|content| {
                content
                    .keys()
                    .any(|kind| kind.starts_with("text/event-stream"))
            }) {
                continue;
            }
            if absent.iter().any(|part| path.contains(part)) {
                continue;
            }
            let method: Method = method.to_uppercase().parse()?;
            let mut request = http.request(method.clone(), format!("{base}{path}"));
            if !control.is_empty() {
                request = request.header("control-token", &control);
            }
            if method == Method::PUT && path.ends_with("/setup") {
                let now = http.get(format!("{base}{path}")).send().await?;
                let tag = now.headers().get("etag").context("no ETag")?;
                request = request.header("if-match", tag);
            }
            let schema = &operation["requestBody"]["content"]["application/json"]["schema"];
            if let Some(reference) = schema["$ref"].as_str() {
                let schema = document.pointer(reference.trim_start_matches('#'));
                let example = &schema.context(reference.to_owned())?["example"];
                ensure!(example.is_object(), "{reference} has no example");
                request = request
                    .header("content-type", "application/json")
                    .header("idempotency-key", format!("example-{bodies}"))
                    .body(example.to_string());
                bodies += 1;
            }
            // The robot runs the seed program; what it cannot do, it says.
            let tried = answer(request).await;
            let beyond = |error: &anyhow::Error| error.to_string().contains("\"not-supported\"");
            if tried.as_ref().err().is_some_and(beyond) {
                ensure!(path.ends_with("/speed-override"), "{method} {path}");
                continue;
            }
            let answer = tried.with_context(|| format!("{method} {path}"))?;
            if method == Method::POST && path.ends_with("/control-authority") {
                let lease: Value = serde_json::from_str(&answer)?;
                lease["token"]
                    .as_str()
                    .context("no token")?
                    .clone_into(&mut control);
            }
        }
    }
    assert_eq!(bodies, 24);
    cell.shutdown().await
}

/// The path with its examples; `None` where a parameter has none, because nobody knows a motion's id beforehand.
fn filled(path: &str, operation: &Value) -> Option<String> {
    let mut path = path.to_owned();
    for parameter in operation["parameters"].as_array().into_iter().flatten() {
        if parameter["in"] == "path" {
            let example = parameter["example"].as_str()?;
            path = path.replace(&format!("{{{}}}", parameter["name"].as_str()?), example);
        }
    }
    Some(path)
}

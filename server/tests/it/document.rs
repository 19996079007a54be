//! The OpenAPI document and the pages that show it.

use serde_json::Value;

use crate::support::{FakeRobot, TestServer};

#[tokio::test]
async fn the_document_and_its_pages_are_served() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let served = server.get("/api/v1/openapi.json").await.json();
    assert_eq!(served, serde_json::to_value(server::openapi()).unwrap());
    assert!(server.get("/").await.body.contains("/docs/"));
    let page = server.get("/docs/").await;
    assert_eq!(page.status, 200);
    assert!(page.body.contains("swagger"), "{}", page.body);
    assert_eq!(server.get("/docs/swagger-ui-bundle.js").await.status, 200);
    assert!(
        server::openapi_yaml()
            .unwrap()
            .starts_with("openapi: 3.1.0")
    );
}

#[test]
fn every_operation_says_what_it_answers() {
    let document = serde_json::to_value(server::openapi()).unwrap();
    assert_eq!(document["openapi"], "3.1.0");
    let mut ids = Vec::new();
    for (path, item) in document["paths"].as_object().unwrap() {
        for (method, operation) in item.as_object().unwrap() {
            let name = format!("{method} {path}");
            assert!(operation["summary"].is_string(), "{name} has no summary");
            assert_eq!(
                operation["tags"].as_array().map(Vec::len),
                Some(1),
                "{name}"
            );
            ids.push(operation["operationId"].as_str().unwrap().to_owned());
            let responses = operation["responses"].as_object().unwrap();
            assert!(
                responses.keys().any(|status| status.starts_with('2')),
                "{name}"
            );
            assert!(responses.contains_key("500"), "{name}");
            for (status, response) in responses {
                assert!(status.parse::<u16>().is_ok(), "{name} answers {status}");
                assert!(
                    response["description"]
                        .as_str()
                        .is_some_and(|text| !text.is_empty()),
                    "{name} {status}"
                );
            }
            if method == "post" && operation["requestBody"].is_object() {
                for status in ["408", "413", "415", "422"] {
                    assert!(
                        responses.contains_key(status),
                        "{name} does not document {status}"
                    );
                }
            }
        }
    }
    let count = ids.len();
    ids.sort();
    ids.dedup();
    assert_eq!(ids.len(), count, "two operations share an id");
}

#[test]
fn every_reference_of_the_document_leads_somewhere() {
    fn references(value: &Value, found: &mut Vec<String>) {
        match value {
            Value::Object(object) => {
                if let Some(Value::String(reference)) = object.get("$ref") {
                    found.push(reference.clone());
                }
                object.values().for_each(|value| references(value, found));
            }
            Value::Array(values) => values.iter().for_each(|value| references(value, found)),
            Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
        }
    }
    let document = serde_json::to_value(server::openapi()).unwrap();
    let mut found = Vec::new();
    references(&document, &mut found);
    assert!(found.len() > 20);
    for reference in found {
        let pointer = reference.strip_prefix('#').unwrap();
        assert!(
            document.pointer(pointer).is_some(),
            "{reference} leads nowhere"
        );
    }
}

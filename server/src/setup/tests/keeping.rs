use std::sync::Arc;

use api::setup::SetupFile;

use super::support::{DEMO, file, robots};
use crate::config::SetupSource;
use crate::setup::{BasedOn, ChangeError, Edit, Resource, SetupBook, StoreError};

fn book(source: &SetupSource) -> Arc<SetupBook> {
    Arc::new(SetupBook::open(Some(source), robots()).unwrap())
}

fn in_memory() -> Arc<SetupBook> {
    book(&SetupSource::Memory(DEMO.to_owned()))
}

fn based_on(etag: &str) -> BasedOn {
    BasedOn(vec![etag.to_owned()])
}

/// Gives the cell another name.
fn rename(name: &'static str) -> impl FnOnce(&mut SetupFile) -> Result<Edit, ChangeError> {
    move |file| {
        file.name = Some(name.to_owned());
        Ok(Edit::Put)
    }
}

#[tokio::test]
async fn h12_of_two_changes_of_one_revision_one_holds_and_the_other_is_told() {
    let book = in_memory();
    let etag = book.current().etag.clone();
    let first = book.change(based_on(&etag), Resource::Header, rename("First"));
    let second = book.change(based_on(&etag), Resource::Header, rename("Second"));
    let (first, second) = tokio::join!(first, second);
    let stale =
        |outcome: &Result<_, ChangeError>| matches!(outcome, Err(ChangeError::Stale { .. }));
    assert!(stale(&first) != stale(&second), "{first:?} {second:?}");
    let holds = book.current();
    assert_eq!(holds.revision, 2);
    let winner = if first.is_ok() { "First" } else { "Second" };
    assert_eq!(holds.file.name.as_deref(), Some(winner));
}

#[tokio::test]
async fn whoever_watches_sees_a_change_and_a_change_of_nothing_is_none() {
    let book = in_memory();
    let mut watched = book.watch();
    watched.mark_unchanged();
    let etag = book.current().etag.clone();
    let changed = book.change(based_on(&etag), Resource::Header, rename("Demo cell"));
    let changed = changed.await.unwrap();
    assert_eq!(
        (changed.revision, &*changed.etag, changed.changed.len()),
        (1, &*etag, 0)
    );
    assert!(!watched.has_changed().unwrap());
    let changed = book.change(based_on(&etag), Resource::Header, rename("Other"));
    assert_eq!(changed.await.unwrap().changed, ["name"]);
    assert!(watched.has_changed().unwrap());
    assert_eq!(watched.borrow_and_update().revision, 2);
}

#[tokio::test]
async fn what_running_work_uses_is_not_changed() {
    let book = in_memory();
    book.refuse_while(Arc::new(|resource: &Resource| {
        let used = Resource::Place("rack/a".to_owned());
        (*resource == used).then(|| "job 7 brings a load there".to_owned())
    }));
    let etag = book.current().etag.clone();
    let change = |place: &'static str| {
        book.change(
            based_on(&etag),
            Resource::Place(place.to_owned()),
            move |file| {
                let mut places = file.places.iter_mut();
                let found = places.find(|known| known.id == place).unwrap();
                found.name = Some("Renamed".to_owned());
                Ok(Edit::Put)
            },
        )
    };
    let Err(ChangeError::InUse { resource, reason }) = change("rack/a").await else {
        panic!("a place in use was changed");
    };
    assert_eq!(
        (resource.to_string(), &*reason),
        ("places/rack/a".to_owned(), "job 7 brings a load there")
    );
    assert_eq!(book.current().revision, 1);
    assert_eq!(change("rack/b").await.unwrap().changed, ["places/rack/b"]);
}

#[tokio::test]
async fn a_change_is_in_the_file_before_anyone_hears_of_it_and_holds_after_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cell.setup.toml");
    std::fs::write(&path, DEMO).unwrap();
    let source = SetupSource::File(path.clone());
    let first = book(&source);
    assert_eq!(first.current().revision, 1);
    let etag = first.current().etag.clone();
    let changed = first
        .change(based_on(&etag), Resource::Header, rename("Kept"))
        .await
        .unwrap();
    assert!(
        std::fs::read_to_string(&path)
            .unwrap()
            .contains("name = \"Kept\"")
    );
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(left.len(), 1, "{left:?}");

    let again = book(&source);
    let kept = again.current();
    assert_eq!((kept.revision, &kept.etag), (2, &changed.etag));
    assert_eq!(kept.file, first.current().file);
    // Whoever edits the file by hand makes another revision of it, although its number is the same.
    let text = std::fs::read_to_string(&path)
        .unwrap()
        .replace("Kept", "By hand");
    std::fs::write(&path, text).unwrap();
    let edited = book(&source);
    assert_eq!(edited.current().revision, 2);
    assert_ne!(edited.current().etag, changed.etag);
}

#[tokio::test]
async fn what_cannot_be_written_is_not_changed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("gone").join("cell.setup.toml");
    let book = book(&SetupSource::File(path.clone()));
    assert_eq!(book.current().file, SetupFile::empty());
    let etag = book.current().etag.clone();
    let change = || book.change(based_on(&etag), Resource::Header, rename("Lost"));
    let Err(ChangeError::NotKept(StoreError::Write { .. })) = change().await else {
        panic!("a file was written into no folder");
    };
    assert_eq!(
        (book.current().revision, book.current().file.name.as_deref()),
        (1, None)
    );
    std::fs::create_dir(path.parent().unwrap()).unwrap();
    assert_eq!(change().await.unwrap().revision, 2);
}

#[tokio::test]
async fn a_change_is_carried_to_its_end_when_the_caller_goes_away() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cell.setup.toml");
    let book = book(&SetupSource::File(path.clone()));
    let mut watched = book.watch();
    watched.mark_unchanged();
    let etag = book.current().etag.clone();
    {
        let mut change = Box::pin(book.change(based_on(&etag), Resource::Header, rename("Anyway")));
        // It has begun, and nobody waits for it any longer.
        let waker = std::task::Waker::noop();
        let mut context = std::task::Context::from_waker(waker);
        assert!(change.as_mut().poll(&mut context).is_pending());
    }
    watched.changed().await.unwrap();
    assert_eq!(book.current().file.name.as_deref(), Some("Anyway"));
    assert!(std::fs::read_to_string(&path).unwrap().contains("Anyway"));
}

#[test]
fn a_file_that_does_not_fit_keeps_the_server_from_starting_and_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cell.setup.toml");
    for (text, said) in [
        ("format = 1\nspeed = 3", "speed: is no section of a set-up"),
        ("format = 1\n[[zones]", "line 2"),
        ("format = 3", "format: is 3; it must be 1"),
    ] {
        std::fs::write(&path, text).unwrap();
        let opened = SetupBook::open(Some(&SetupSource::File(path.clone())), robots());
        let error = opened.unwrap_err().to_string();
        assert!(
            error.contains("cell.setup.toml") && error.contains(said),
            "{error}"
        );
    }
    let folder_itself = SetupSource::File(folder.path().to_owned());
    let opened = SetupBook::open(Some(&folder_itself), robots());
    assert!(matches!(opened, Err(StoreError::Read { .. })));
}

#[test]
fn an_edit_touches_what_it_changes_and_nothing_else() {
    let before = file(DEMO);
    let mut after = before.clone();
    let _gone = after.loads.remove(0);
    after.zones[1].name = Some("Hall".to_owned());
    after.tools[0].radius_mm = None;
    // The order of a list is no change.
    after.places.reverse();
    let touched: Vec<_> = super::super::resource::touched(&before, &after)
        .iter()
        .map(Resource::to_string)
        .collect();
    assert_eq!(touched, ["tools/r1/1", "zones/floor", "loads/load-1"]);
}

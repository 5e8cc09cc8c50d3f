//! Bags in `SQLite` databases that are open, unfinished, or laid out in unusual ways.

use std::path::{Path, PathBuf};

use rusqlite::Connection;

use sprung_log::{Channels, Input, LogFile, LogSource};

use crate::keys::TOPICS;
use crate::support::{Files, difference, experiment, fixture, read_log, read_source, says, truth};

/// An empty folder for one test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("db3-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Copies a fixture into a folder, and opens it.
fn bag(folder: &Path) -> Connection {
    let path = folder.join("run.db3");
    std::fs::copy(fixture("plain.db3"), &path).unwrap();
    Connection::open(path).unwrap()
}

fn read(folder: PathBuf) -> Result<Vec<Vec<f64>>, String> {
    read_log(&Files::Folder(folder), "run.db3", TOPICS)
}

/// Names of the files in a folder.
fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut all: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    all.sort();
    all
}

#[test]
fn messages_in_a_write_ahead_log_are_read() {
    let (open, killed) = (folder("wal-open"), folder("wal"));
    let base = bag(&open);
    base.execute_batch(
        "CREATE TABLE late AS SELECT * FROM messages WHERE id > 300; DELETE FROM messages WHERE id > 300;
         PRAGMA journal_mode = WAL; PRAGMA wal_autocheckpoint = 0;
         INSERT INTO messages SELECT * FROM late;",
    )
    .unwrap();
    // A copy while the recorder runs is like the files of a recorder that was killed.
    std::fs::copy(open.join("run.db3"), killed.join("run.db3")).unwrap();
    let database_only = read(killed.clone()).unwrap();
    assert!(database_only[0].len() < truth()[0].len());
    std::fs::copy(open.join("run.db3-wal"), killed.join("run.db3-wal")).unwrap();
    let before = std::fs::read(killed.join("run.db3-wal")).unwrap();
    assert!(difference(&read(killed.clone()).unwrap(), &truth()) <= 1e-12);
    assert_eq!(names(&killed), ["run.db3", "run.db3-wal"]);
    assert_eq!(std::fs::read(killed.join("run.db3-wal")).unwrap(), before);
}

/// Reads a bag while another connection writes to it.
fn grows(mode: &str) {
    let folder = folder(&format!("growing-{mode}"));
    let recorder = bag(&folder);
    recorder
        .execute_batch(&format!(
            "CREATE TABLE late AS SELECT * FROM messages WHERE id > 300; DELETE FROM messages WHERE id > 300;
             PRAGMA journal_mode = {mode};"
        ))
        .unwrap();
    let writer = std::thread::spawn(move || {
        for last in (350..).step_by(50) {
            std::thread::sleep(std::time::Duration::from_millis(100));
            let insert = "INSERT INTO messages SELECT * FROM late WHERE id > ?1 AND id <= ?2";
            if recorder.execute(insert, [last - 50, last]).unwrap() == 0 {
                break;
            }
        }
    });
    let path = folder.join("run.db3");
    let mut opener = |_: Option<&Path>| -> std::io::Result<Box<dyn Input>> {
        let file = LogFile::new(std::fs::File::open(&path)?, &path);
        Ok(Box::new(file.growing(3.0)))
    };
    let log = experiment(TOPICS).unwrap();
    let channels = Channels::new(&log.robot, log.log.as_ref().unwrap()).unwrap();
    let found = read_source(&mut LogSource::files("run.db3", &mut opener), &channels);
    writer.join().unwrap();
    assert!(difference(&found.unwrap().columns, &truth()) <= 1e-12);
}

#[test]
fn a_bag_that_grows_by_a_write_ahead_log_is_read_to_its_last_message() {
    grows("WAL");
}

#[test]
fn a_bag_that_grows_by_rollback_journals_is_read_to_its_last_message() {
    grows("DELETE");
}

#[test]
fn an_unfinished_transaction_is_refused() {
    let (open, killed) = (folder("journal-open"), folder("journal"));
    let base = bag(&open);
    base.execute_batch(
        "PRAGMA cache_size = 5; BEGIN; UPDATE messages SET timestamp = 0;
         INSERT INTO messages(topic_id, timestamp, data) SELECT topic_id, 1, data FROM messages;",
    )
    .unwrap();
    for name in ["run.db3", "run.db3-journal"] {
        std::fs::copy(open.join(name), killed.join(name)).unwrap();
    }
    let told = [
        "was not closed by its recorder",
        "run.db3-journal",
        "sqlite3",
    ];
    says(&read(killed.clone()).unwrap_err(), &told);
    // The first query that may write completes the bag.
    Connection::open(killed.join("run.db3"))
        .and_then(|base| base.query_row("SELECT count(*) FROM messages", [], |_| Ok(())))
        .unwrap();
    assert!(difference(&read(killed).unwrap(), &truth()) <= 1e-12);
}

#[test]
fn reading_leaves_no_file_beside_a_bag() {
    // These characters have a meaning in the address that SQLite opens.
    let folder = folder("a b?c#d%41ä");
    let base = bag(&folder);
    base.execute_batch("PRAGMA journal_mode = WAL; DELETE FROM topics WHERE name = 'none'")
        .unwrap();
    drop(base);
    assert_eq!(names(&folder), ["run.db3"]);
    assert!(difference(&read(folder.clone()).unwrap(), &truth()) <= 1e-12);
    assert_eq!(names(&folder), ["run.db3"]);
    // The header of the database still declares a write-ahead log.
    let bytes = std::fs::read(folder.join("run.db3")).unwrap();
    assert_eq!(bytes[18..20], [2, 2]);
    let found = read_log(&Files::Memory(vec![("run.db3", bytes)]), "run.db3", TOPICS);
    assert!(difference(&found.unwrap(), &truth()) <= 1e-12);
}

#[test]
fn texts_in_utf_16_and_columns_in_another_order_are_read() {
    let folder = folder("utf16");
    let path = folder.join("run.db3");
    let base = Connection::open(path).unwrap();
    let source = Connection::open(fixture("plain.db3")).unwrap();
    base.execute_batch(
        "PRAGMA encoding = 'UTF-16be';
         CREATE TABLE topics(serialization_format, type, name, id INTEGER PRIMARY KEY);
         CREATE TABLE messages(id INTEGER PRIMARY KEY, data, timestamp, topic_id)",
    )
    .unwrap();
    let copy = |from: &str, to: &str, columns: usize| {
        let mut rows = source.prepare(from).unwrap();
        let mut rows = rows.query([]).unwrap();
        while let Some(row) = rows.next().unwrap() {
            let values = (0..columns).map(|k| row.get::<_, rusqlite::types::Value>(k).unwrap());
            base.execute(to, rusqlite::params_from_iter(values))
                .unwrap();
        }
    };
    copy(
        "SELECT serialization_format, type, name, id FROM topics",
        "INSERT INTO topics VALUES (?1, ?2, ?3, ?4)",
        4,
    );
    copy(
        "SELECT id, data, timestamp, topic_id FROM messages",
        "INSERT INTO messages VALUES (?1, ?2, ?3, ?4)",
        4,
    );
    drop(base);
    assert!(difference(&read(folder).unwrap(), &truth()) <= 1e-12);
}

#[test]
fn databases_that_are_no_bags_are_refused() {
    let cases = [
        (
            "view",
            "ALTER TABLE messages RENAME TO stored;
             CREATE VIEW messages AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT i AS \
             topic_id, i AS timestamp, x'' AS data FROM n",
            "is an SQLite database and no bag of ROS 2; it has the tables",
        ),
        (
            "column",
            "ALTER TABLE messages RENAME COLUMN data TO content",
            "has tables of another shape than a bag of ROS 2",
        ),
        (
            "type",
            "UPDATE messages SET timestamp = 'noon' WHERE id = 7",
            "has tables of another shape than a bag of ROS 2",
        ),
        (
            "encoding",
            "UPDATE topics SET serialization_format = 'json'",
            "are encoded as \"json\"; only \"cdr\" is read",
        ),
        (
            "types",
            "INSERT INTO topics SELECT 9, name, 'std_msgs/msg/Float64', serialization_format, '', '' FROM topics \
             WHERE id = 1",
            "carries two types of messages, sensor_msgs/msg/JointState and std_msgs/msg/Float64",
        ),
        (
            "definition",
            "UPDATE topics SET type = 'my_msgs/msg/State'",
            "does not contain the definition of my_msgs/msg/State; convert the bag",
        ),
    ];
    for (name, change, told) in cases {
        let folder = folder(name);
        bag(&folder).execute_batch(change).unwrap();
        says(&read(folder).unwrap_err(), &["run.db3", told]);
    }
}

const PAGE: usize = 512;

/// Writes a bag of small pages; returns its path and the root pages of two tables.
///
/// - `rest`: statements after those that make the tables.
fn small(folder: &Path, rest: &str, tables: [&str; 2]) -> (PathBuf, [usize; 2]) {
    let path = folder.join("run.db3");
    let base = Connection::open(&path).unwrap();
    base.execute_batch(&format!(
        "PRAGMA page_size = {PAGE};
         CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format);
         INSERT INTO topics VALUES (1, '/joint_states', 'sensor_msgs/msg/JointState', 'cdr'),
             (2, '/motor_states', 'sensor_msgs/msg/JointState', 'cdr');
         CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data);
         INSERT INTO messages VALUES (1, 1, 0, x'00'), (2, 1, 0, x'00'), (3, 1, 0, x'00');
         {rest}"
    ))
    .unwrap();
    let root = |name: &str| -> usize {
        let sql = "SELECT rootpage FROM sqlite_schema WHERE name = ?1";
        base.query_row(sql, [name], |row| row.get::<_, u32>(0))
            .unwrap() as usize
    };
    let roots = tables.map(root);
    (path, roots)
}

/// Eight pages, each of which leads to the next one 40 times: 40^8 rows in a file of a few pages.
#[test]
fn pages_that_lead_to_each_other_without_end_are_refused() {
    let folder = folder("pages");
    let rest = "CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type, encoding, encoded_message_definition);
         INSERT INTO message_definitions VALUES (1, 'other', 'other', 'other');
         CREATE TABLE rest(x); INSERT INTO rest VALUES (zeroblob(5000))";
    let (path, [first, other]) = small(&folder, rest, ["message_definitions", "rest"]);
    let mut bytes = std::fs::read(&path).unwrap();
    let leaf = bytes[(first - 1) * PAGE..first * PAGE].to_vec();
    let pages: Vec<usize> = std::iter::once(first)
        .chain((0..8).map(|k| other + k))
        .collect();
    for pair in pages.windows(2) {
        let page = &mut bytes[(pair[0] - 1) * PAGE..pair[0] * PAGE];
        page.fill(0);
        let child = (pair[1] as u32).to_be_bytes();
        // An inner page: 40 cells of a child and a key of one byte, and the last child.
        page[..12].copy_from_slice(&[
            5, 0, 0, 0, 40, 0, 0, 0, child[0], child[1], child[2], child[3],
        ]);
        for cell in 0..40 {
            let at = 300 + 5 * cell;
            page[12 + 2 * cell..14 + 2 * cell].copy_from_slice(&(at as u16).to_be_bytes());
            page[at..at + 5].copy_from_slice(&[child[0], child[1], child[2], child[3], 1]);
        }
    }
    let last = pages[pages.len() - 1];
    bytes[(last - 1) * PAGE..last * PAGE].copy_from_slice(&leaf);
    std::fs::write(&path, bytes).unwrap();
    let told = ["its database is damaged", "lead to each other without end"];
    says(&read(folder).unwrap_err(), &told);
}

#[test]
fn rows_that_lead_back_to_earlier_rows_are_refused() {
    let folder = folder("rows");
    let (path, [root, _]) = small(&folder, "", ["messages", "topics"]);
    let mut bytes = std::fs::read(&path).unwrap();
    let page = &mut bytes[(root - 1) * PAGE..root * PAGE];
    // The cell of the third row: length and number, a byte each.
    let cell = usize::from(u16::from_be_bytes([page[12], page[13]]));
    assert_eq!(page[cell + 1], 3);
    page[cell + 1] = 1;
    std::fs::write(&path, bytes).unwrap();
    let told = ["its database is damaged", "its row 1 follows row 2"];
    says(&read(folder).unwrap_err(), &told);
}

//! `--html`: the page, as a text and in a browser.

use std::fs;
use std::process::Command;

use crate::recorded::{Folder, keep, record, samples};

/// Three requests: the first moved by 0.5 m, the second by 0.25 m, the third equal.
fn moved() -> Folder {
    Folder::with("a.mcap", |part| {
        if part.key.sequence < 2 {
            samples(part)[4].position[1] += 0.5 / (1.0 + part.key.sequence as f64);
        }
        true
    })
}

fn page(folder: &Folder) -> String {
    let (code, _, error) = folder.run(&["check", "a.mcap", "--html", "a.html"]);
    assert_eq!((code, error.as_str()), (4, ""));
    fs::read_to_string(folder.path("a.html")).unwrap()
}

#[test]
fn the_page_has_a_row_and_details_for_each_answer_that_moved() {
    let page = page(&moved());
    assert_eq!(page.matches("<tr class=\"row\"").count(), 2);
    for number in 0..2 {
        let opening = format!("<script type=\"text/plain\" id=\"d{number}\">");
        let details = page.split(&opening).nth(1).expect("it has details");
        let details = details.split("</script>").next().unwrap();
        let words = ["answer 0 moved: position by", "class=\"before\"", "class=\"apart\"", "m/s"];
        for word in words {
            assert!(details.contains(word), "{word} is not in the details");
        }
        assert!(details.contains("<caption>Legs now"), "both legs' tables");
    }
    assert!(page.contains("data-v=\"0.5\""), "the deviation is a number to sort by");
}

#[test]
fn the_page_needs_no_network() {
    let page = page(&moved());
    let foreign =
        page.split("http").skip(1).filter(|rest| !rest.starts_with("://www.w3.org/2000/svg"));
    assert_eq!(foreign.count(), 0);
    for word in [" src=", "@import", "url(", "fetch("] {
        assert!(!page.contains(word), "{word}");
    }
}

#[test]
fn a_page_overwrites_nothing() {
    let folder = moved();
    page(&folder);
    let again = ["check", "a.mcap", "--html", "a.html"];
    folder.check(&again, 1, "", "a.html exists; --overwrite replaces it");
    folder.check(&[&again[..], &["--overwrite"]].concat(), 4, "1 equal, 2 different", "");
    folder.check(&["check", "a.mcap", "--html", "a.mcap", "--overwrite"], 1, "", "read from");
}

#[test]
fn a_page_about_two_recordings_names_both() {
    let folder = moved();
    record(&folder.path("b.mcap"), 8, keep);
    let (code, _, error) = folder.run(&["diff", "a.mcap", "b.mcap", "--html", "d.html"]);
    assert_eq!((code, error.as_str()), (4, ""));
    let page = fs::read_to_string(folder.path("d.html")).unwrap();
    assert!(page.contains("a.mcap and b.mcap") && page.contains("class=\"before\""));
    assert_eq!(page.matches("<tr class=\"row\"").count(), 2);
}

#[test]
fn names_of_files_are_text() {
    let name = "<b> & \"c\".mcap";
    let folder = Folder::with(name, keep);
    folder.check(&["check", name, "--html", "a.html"], 0, "3 equal", "");
    let page = fs::read_to_string(folder.path("a.html")).unwrap();
    assert!(page.contains("&lt;b&gt; &amp; &quot;c&quot;.mcap") && !page.contains("<b>"));
}

/// Sorts, filters and opens in a browser. `CLEARWAY_CHROMIUM` names it.
#[test]
#[ignore = "needs Chromium"]
fn the_page_sorts_filters_and_opens() {
    let folder = moved();
    let drive = "<script>
        const said = [], say = what => said.push(what), head = list.tHead.rows[0].cells;
        const shown = () => [...body.rows].filter(row => !row.hidden).map(row => row.dataset.n).join();
        const find = name => [...head].find(cell => cell.textContent.startsWith(name)).firstChild;
        find('position').click(); say(shown());
        find('position').click(); say(shown());
        filter.value = 'a.mcap 2.500e-1'; filter.dispatchEvent(new Event('input')); say(shown());
        const row = rows.find(row => !row.hidden);
        row.focus(); row.dispatchEvent(new KeyboardEvent('keydown', { key: 'Enter', bubbles: true }));
        say(document.querySelectorAll('td.details .picture svg path.before').length);
        boxes[0].click(); say(shown());
        boxes[0].click(); filter.value = ''; filter.dispatchEvent(new Event('input'));
        document.getElementById('all').click(); say(document.querySelectorAll('td.details').length);
        document.body.dataset.said = said.join('|');
    </script></html>";
    let driven = page(&folder).replace("</html>", drive);
    fs::write(folder.path("driven.html"), driven).unwrap();
    let program = std::env::var("CLEARWAY_CHROMIUM").unwrap_or_else(|_| "chromium".to_owned());
    let browse = |arguments: &[&str]| {
        let mut command = Command::new(&program);
        command.args(["--headless", "--no-sandbox", "--disable-gpu"]).args(arguments);
        command.current_dir(folder.path(""));
        let output = command.arg(folder.path("driven.html")).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let tree = browse(&["--dump-dom"]);
    assert!(tree.contains("data-said=\"0,1|1,0|1|1||2\""), "{}", &tree[..tree.len().min(4_000)]);
    browse(&["--screenshot=page.png", "--window-size=1300,2000"]);
    // A page of one colour is much smaller.
    assert!(fs::metadata(folder.path("page.png")).unwrap().len() > 50_000);
}

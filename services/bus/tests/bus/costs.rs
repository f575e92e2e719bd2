use crate::support::*;
use bus::*;
use std::time::Instant;

#[test]
#[ignore = "prints"]
fn costs() {
    let test = TestDomain::new();
    let begin = Instant::now();
    let _planner = Planner::start(&test.domain, ServerOptions::default());
    println!("open {:?}", begin.elapsed());
    let mut clients = Vec::new();
    for i in 0..30 {
        let begin = Instant::now();
        clients.push(Client::connect(&test.domain, Wait::Hybrid).unwrap());
        println!("connect {i} {:?}", begin.elapsed());
    }
}
#[test]
#[ignore = "prints"]
fn cleanup_cost() {
    use iceoryx2::prelude::*;
    let mut config = Config::default();
    config.global.prefix = FileName::new(b"iox2_cc_").unwrap();
    let mut nodes = vec![];
    for i in 0..12 {
        let begin = Instant::now();
        let node = NodeBuilder::new().config(&config).create::<ipc::Service>().unwrap();
        let a = begin.elapsed();
        let begin = Instant::now();
        let s = node.service_builder(&"x".try_into().unwrap()).event().open_or_create().unwrap();
        let b = begin.elapsed();
        let begin = Instant::now();
        node.try_cleanup_dead_nodes();
        println!("{i}: node {a:?} service {b:?} cleanup {:?}", begin.elapsed());
        nodes.push((node, s));
    }
    let begin = Instant::now();
    for _ in 0..1000 {
        std::hint::black_box(nodes[0].0.wait(std::time::Duration::ZERO)).unwrap();
    }
    println!("node.wait(0) {:?}", begin.elapsed() / 1000);
}

// A planner in this process, for the example of the first page.

/// Answers requests until it is dropped.
pub struct Planner {
    domain: clearway_client::Domain,
    ended: std::sync::Arc<std::sync::atomic::AtomicBool>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Planner {
    pub fn start() -> Self {
        let name = format!("first-page-{}", std::process::id());
        let domain = clearway_client::Domain::new(&name).unwrap();
        let ended = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false));
        let (say, ready) = std::sync::mpsc::channel();
        let thread = std::thread::spawn({
            let (domain, ended) = (domain.clone(), std::sync::Arc::clone(&ended));
            move || {
                let mut server = bus::Server::open(&domain, &bus::ServerOptions::default()).unwrap();
                say.send(()).unwrap();
                let mut workspace = answer::Workspace::default();
                let mut memory = Vec::new();
                while !ended.load(std::sync::atomic::Ordering::Relaxed) {
                    let Some(mut incoming) = server.receive() else {
                        std::thread::sleep(std::time::Duration::from_millis(1));
                        continue;
                    };
                    let header = incoming.copy(usize::MAX, &mut memory).unwrap();
                    let stop = answer::StopFlag::new();
                    let _ = workspace.answer(&header, &memory, &stop, &mut incoming.reply());
                    let _ = incoming.finish();
                }
            }
        });
        ready.recv().unwrap();
        Self { domain, ended, thread: Some(thread) }
    }

    pub fn domain(&self) -> clearway_client::Domain {
        self.domain.clone()
    }
}

impl Drop for Planner {
    fn drop(&mut self) {
        self.ended.store(true, std::sync::atomic::Ordering::Relaxed);
        self.thread.take().unwrap().join().unwrap();
    }
}

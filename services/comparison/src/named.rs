//! Free spaces that a recording's requests name.

use std::collections::BTreeMap;

use schemas::message::{Digest, FreeSpace, Request, RequestContent};

/// The free spaces that requests have carried together with their names, so that a request with the
/// name alone can be answered, or sent, by itself.
#[derive(Debug, Default)]
pub struct NamedFreeSpaces {
    known: BTreeMap<Digest, FreeSpace>,
}

impl NamedFreeSpaces {
    /// Puts the free space in place of a name alone, if it is known, which leaves the reply the
    /// same, byte for byte. Remembers a free space that the request carries with its right name.
    pub fn resolve(&mut self, request: &mut Request) {
        let RequestContent::Scene(scene) = &mut request.content else { return };
        let Some(name) = scene.free_space.named else { return };
        let alone = FreeSpace { named: Some(name), ..FreeSpace::default() };
        if scene.free_space == alone {
            if let Some(known) = self.known.get(&name) {
                scene.free_space.clone_from(known);
            }
        } else if !self.known.contains_key(&name) && scene.free_space.digest() == name {
            // Without the name: to check it draws from the budget what the name alone does not.
            let content = FreeSpace { named: None, ..scene.free_space.clone() };
            self.known.insert(name, content);
        }
    }
}

#[cfg(test)]
mod tests {
    use schemas::message::{AxisBox, RequestKey, SceneRequest};

    use super::*;

    fn request(free_space: FreeSpace) -> Request {
        let scene = SceneRequest { free_space, ..SceneRequest::empty() };
        let key = RequestKey::default();
        Request { key, sent_ns: 0, content: RequestContent::Scene(scene) }
    }

    fn content() -> FreeSpace {
        FreeSpace { channels: Some(vec![AxisBox::default()]), ..FreeSpace::default() }
    }

    fn alone(name: Digest) -> FreeSpace {
        FreeSpace { named: Some(name), ..FreeSpace::default() }
    }

    #[test]
    fn a_name_alone_gets_the_free_space_sent_before() {
        let mut spaces = NamedFreeSpaces::default();
        let name = content().digest();
        let mut early = request(alone(name));
        spaces.resolve(&mut early);
        assert_eq!(early, request(alone(name)), "nothing is known yet");
        spaces.resolve(&mut request(FreeSpace { named: Some(name), ..content() }));
        let mut late = request(alone(name));
        spaces.resolve(&mut late);
        assert_eq!(late, request(content()));
    }

    #[test]
    fn a_wrong_name_is_not_kept() {
        let mut spaces = NamedFreeSpaces::default();
        let wrong = Digest([7; 32]);
        spaces.resolve(&mut request(FreeSpace { named: Some(wrong), ..content() }));
        let mut late = request(alone(wrong));
        spaces.resolve(&mut late);
        assert_eq!(late, request(alone(wrong)));
    }
}

pub fn draw(_: &schemas::message::SceneRequest, _: &schemas::message::Reply) -> String {
    String::new()
}

// Shows a lesson of Lappet in H5P: its page in a frame of its own, and what it reports as xAPI statements.
var H5P = H5P || {};

H5P.Lappet = (function ($, EventDispatcher) {
  "use strict";

  function Lappet(content, contentId, extras) {
    EventDispatcher.call(this);
    this.content = content;
    this.contentId = contentId;
    this.state = (extras && extras.previousState) || null;
    this.score = 0;
    this.maxScore = 0;
    this.answered = false;
    this.completed = false;
    window.addEventListener("message", this.hear.bind(this));
  }

  Lappet.prototype = Object.create(EventDispatcher.prototype);
  Lappet.prototype.constructor = Lappet;

  Lappet.prototype.attach = function ($container) {
    var self = this;
    var place = $container.get(0);
    place.classList.add("h5p-lappet");
    this.setActivityStarted();
    fetch(H5P.getPath(this.content.page.path, this.contentId))
      .then(function (response) {
        if (!response.ok) throw new Error(response.status + " " + response.statusText);
        return response.text();
      })
      .then(function (page) {
        var frame = document.createElement("iframe");
        frame.title = (self.content.metadata && self.content.metadata.title) || "Lappet";
        frame.allow = "fullscreen";
        frame.srcdoc = page;
        place.replaceChildren(frame);
        self.frame = frame;
        self.trigger("resize");
      })
      .catch(function (error) {
        var said = document.createElement("p");
        said.textContent = "The lesson could not be loaded: " + error.message;
        place.replaceChildren(said);
      });
  };

  // The lesson says where the student stands; what it asks for is the state of an earlier visit.
  Lappet.prototype.hear = function (event) {
    if (!this.frame || event.source !== this.frame.contentWindow || !event.data || !event.data.lappet) return;
    var told = event.data;
    if (told.lappet === "begin") {
      event.source.postMessage({ lappet: "resume", state: this.state }, "*");
    } else if (told.lappet === "progress") {
      this.state = told.state;
      this.score = told.right;
      this.maxScore = told.questions;
      this.answered = told.answered > 0;
      if (told.completed && !this.completed) {
        this.completed = true;
        this.triggerXAPIScored(told.right, told.questions, "completed", true, told.passed !== false);
      }
    } else if (told.lappet === "answered") {
      this.report(told);
    }
  };

  Lappet.prototype.report = function (told) {
    var statement = this.createXAPIEventTemplate("answered");
    var definition = statement.getVerifiedStatementValue(["object", "definition"]);
    definition.name = { "en-US": told.ask };
    definition.type = "http://adlnet.gov/expapi/activities/cmi.interaction";
    definition.interactionType = "other";
    statement.setScoredResult(told.right ? 1 : 0, 1, this, true, told.right);
    statement.data.statement.result.response = told.response;
    this.trigger(statement);
  };

  Lappet.prototype.getCurrentState = function () {
    return this.state || undefined;
  };
  Lappet.prototype.getScore = function () {
    return this.score;
  };
  Lappet.prototype.getMaxScore = function () {
    return this.maxScore;
  };
  Lappet.prototype.getAnswerGiven = function () {
    return this.answered;
  };

  return Lappet;
})(H5P.jQuery, H5P.EventDispatcher);

import "crease-avatar";

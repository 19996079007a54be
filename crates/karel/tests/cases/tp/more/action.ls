/PROG  ACTION
/ATTR
OWNER		= MNEDITOR;
DEFAULT_GROUP	= 1,*,*,*,*;
/MN
   1:  R[2]=R[2]+1 ;
   2:  R[3]=R[3]+1 ;
   3:  WAIT .05(sec) ;
/POS
/END
